"""Builds measurement sets from pandas, xarray, HDF5, and dictionaries of arrays."""

from __future__ import annotations

import hashlib
import html
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, fields
from datetime import date
from pathlib import Path
from typing import Any, Self, TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray

from arctrue.api.frame import SET_COLUMNS, Found, Frame, columns_of
from arctrue.base.extras import optional
from arctrue.base.printable import one_line
from arctrue.base.runs import run_spans
from arctrue.base.similar import did_you_mean
from arctrue.base.typed_content import ContentError, typed
from arctrue.importing.motion import passes
from arctrue.importing.readers.hdf5 import refuse_other_files
from arctrue.importing.readers.unpacked_size import refuse_above_limit
from arctrue.measurement import (
    Capture,
    MeasurementError,
    MeasurementSet,
    Reference,
    read_measurement_set,
    write_measurement_set,
)
from arctrue.measurement.date import moment
from arctrue.measurement.description import Keys
from arctrue.measurement.digest import set_digest
from arctrue.measurement.error_sign import of_opposite_sign
from arctrue.measurement.reader import count_on_past_the_turn, require_heads
from arctrue.measurement.uncertainty import of_zero
from arctrue.measurement.wraps import without_wraps

CHANNELS = ("capture", "reference")
SECTION_OF = {
    **dict.fromkeys(
        (
            *("counts_per_rev", "grating_lines", "disc_diameter_mm", "head_separation_deg"),
            *("head_places_deg", "index_detection_arcsec", "drive_gear_teeth"),
            "index_repeatability_counts",
        ),
        "table",
    ),
    "clock_hz": "capture",
    **dict.fromkeys(
        ("instrument", "faces", "standard_uncertainty_arcsec", "clock_offset_s"), "reference"
    ),
}
"""Section of ``measurement.toml`` for each keyword."""
TEXTS = ("title", "date")
"""Keywords that stand before the first section of ``measurement.toml``."""


class Metadata(TypedDict, total=False):
    """Description of table, heads and reference: the keys of ``measurement.toml``."""

    title: str
    date: str
    counts_per_rev: int
    head_separation_deg: float
    head_places_deg: tuple[float, ...]
    index_detection_arcsec: float
    index_repeatability_counts: float
    grating_lines: int
    disc_diameter_mm: float
    drive_gear_teeth: float
    clock_hz: float
    instrument: str
    faces: int
    standard_uncertainty_arcsec: float
    clock_offset_s: float


@dataclass(frozen=True, repr=False)
class Dataset(MeasurementSet):
    """A measurement set: measured data of a rotary table, and the known facts about the table.

    Every function of ``arctrue`` that needs a measurement set accepts a Dataset. A Dataset is made
    by :meth:`read_set`, :meth:`from_pandas`, :meth:`from_xarray`, :meth:`from_hdf5` or
    :meth:`from_arrays`.

    Parameters
    ----------
    table : Table
        Counts per turn, places of the heads, disc and drive gear.
    capture : Capture, optional
        Readings of all heads over time, arrays of shape (rows,).
    reference : Reference, optional
        Errors of head 1 against a reference, arrays of shape (rows,).
    title : str, optional
        One line that names the set.
    origin : Origin, optional
        The command that made the set.
    other : mapping, optional
        Values of keys in ``measurement.toml`` that ArcTrue does not know, by dotted key.
    warnings : tuple of str, optional
        Remarks on the data for the user, one sentence each.
    folder : Path, optional
        The folder from which the set was read.
    date : datetime, optional
        Time of the measurement, with its time zone.
    """

    @classmethod
    def of(cls, measurement: MeasurementSet) -> Self:
        """Return the content of any measurement set as a Dataset.

        Parameters
        ----------
        measurement : MeasurementSet
            The set; its arrays are not copied.

        Returns
        -------
        Dataset
            The same content.
        """
        if isinstance(measurement, cls):
            return measurement
        return cls(**{item.name: getattr(measurement, item.name) for item in fields(measurement)})

    @classmethod
    def read_set(cls, folder: Path | str) -> Self:
        """Read the folder of a measurement set.

        Parameters
        ----------
        folder : Path or str
            The folder with ``measurement.toml``.

        Returns
        -------
        Dataset
            The set with the content of its files.

        Raises
        ------
        MeasurementError
            A file is missing or wrong; the text states file, row, column, expected and found
            content.
        """
        return cls.of(read_measurement_set(folder))

    @classmethod
    def from_arrays(
        cls,
        capture: Mapping[str, Any] | None = None,
        reference: Mapping[str, Any] | None = None,
        *,
        columns: Mapping[str, str] | None = None,
        units: Mapping[str, Any] | None = None,
        **metadata: Unpack[Metadata],
    ) -> Self:
        """Make a set from named arrays, lists or quantities.

        Parameters
        ----------
        capture : mapping of str to array, shape (rows,), optional
            Columns of all heads over time: time, head1, head2 and, if present, run, temperature, u,
            mask, head3, head4. Further columns of numbers are conditions.
        reference : mapping of str to array, shape (rows,), optional
            Columns of head 1 against a reference: target, error (reading minus true angle) and, if
            present, time, run, cycle, direction, head1, temperature, u, mask.
        columns : mapping of str to str, optional
            The name of the column that contains a quantity: ``{"head1": "enc_a"}``. Columns with
            the name of the quantity or of the set's own column need no entry.
        units : mapping of str to str or astropy unit, optional
            The unit of a quantity or column: ``{"head1": "deg"}``. An entry is needed if neither
            the column (astropy, xarray, HDF5) nor the end of its name (``az_deg``) states the unit.
        **metadata
            Keys of ``measurement.toml``: ``counts_per_rev`` (counts per turn),
            ``head_separation_deg`` or ``head_places_deg`` (degrees), ``grating_lines``,
            ``disc_diameter_mm``, ``drive_gear_teeth``, ``index_detection_arcsec``,
            ``index_repeatability_counts``, ``clock_hz``, ``instrument``, ``faces``,
            ``standard_uncertainty_arcsec``, ``clock_offset_s`` (s), ``title``, ``date`` (ISO 8601).

        Returns
        -------
        Dataset
            Counts, degrees, arcseconds, seconds and °C, as in a measurement set.

        Raises
        ------
        MeasurementError
            A column is missing, has no unit, or has a wrong value; the text names the column, the
            expected content and the remedy.
        TypeError
            A keyword is not known.

        Examples
        --------
        >>> import numpy as np
        >>> angle = np.arange(0.0, 360.0, 15.0)
        >>> error = 2.0 * np.cos(np.deg2rad(angle))
        >>> data = Dataset.from_arrays(reference={"target_deg": angle, "error_arcsec": error})
        >>> data.reference.error_arcsec.max().item()
        2.0
        """
        return cls._made(
            [
                Frame(name, dict(frame))
                for name, frame in zip(CHANNELS, (capture, reference), strict=True)
                if frame is not None
            ],
            columns,
            units,
            metadata,
        )

    @classmethod
    def from_pandas(
        cls,
        capture: Any = None,
        reference: Any = None,
        *,
        columns: Mapping[str, str] | None = None,
        units: Mapping[str, Any] | None = None,
        **metadata: Unpack[Metadata],
    ) -> Self:
        """Make a set from data frames.

        Parameters
        ----------
        capture : pandas.DataFrame, optional
            Readings of all heads over time, one row per sample; columns as in :meth:`from_arrays`.
            A column of dates is taken as the time.
        reference : pandas.DataFrame, optional
            Errors of head 1 against a reference, one row per comparison.
        columns : mapping of str to str, optional
            As in :meth:`from_arrays`.
        units : mapping of str to str or astropy unit, optional
            As in :meth:`from_arrays`; otherwise a unit in ``frame.attrs["units"]`` is used.
        **metadata
            As in :meth:`from_arrays`.

        Returns
        -------
        Dataset
            As in :meth:`from_arrays`; the rows keep the order of the frame, and its index is not
            used.

        Raises
        ------
        MeasurementError
            As in :meth:`from_arrays`.
        TypeError
            An argument is not a data frame, or a keyword is unknown.
        """
        frames = []
        for name, table in zip(CHANNELS, (capture, reference), strict=True):
            if table is None:
                continue
            if not (hasattr(table, "columns") and hasattr(table, "__getitem__")):
                raise TypeError(
                    f"{name}: expected a pandas.DataFrame, found {type(table).__name__}; "
                    "from_arrays takes a dictionary of arrays"
                )
            names = list(table.columns)
            twice = sorted({str(one) for one in names if names.count(one) > 1})
            if twice:
                raise MeasurementError(
                    "format", Path(name), "occurs twice; rename one of the two", column=twice[0]
                )
            stated = (getattr(table, "attrs", None) or {}).get("units", {})
            frames.append(Frame(name, {str(one): table[one] for one in names}, stated))
        return cls._made(frames, columns, units, metadata)

    @classmethod
    def from_xarray(
        cls,
        capture: Any = None,
        reference: Any = None,
        *,
        columns: Mapping[str, str] | None = None,
        units: Mapping[str, Any] | None = None,
        **metadata: Unpack[Metadata],
    ) -> Self:
        """Make a set from xarray datasets.

        Parameters
        ----------
        capture : xarray.Dataset, optional
            Readings of all heads over time; variables and coordinates of one dimension are columns
            as in :meth:`from_arrays`. ``attrs["units"]`` of a variable is its unit.
        reference : xarray.Dataset, optional
            Errors of head 1 against a reference, in the same form.
        columns : mapping of str to str, optional
            As in :meth:`from_arrays`.
        units : mapping of str to str or astropy unit, optional
            As in :meth:`from_arrays`; this argument takes precedence over ``attrs``.
        **metadata
            As in :meth:`from_arrays`. Attributes of the datasets with these names are used if a
            keyword is not given.

        Returns
        -------
        Dataset
            As in :meth:`from_arrays`.

        Raises
        ------
        MeasurementError
            The columns have different dimensions, or as in :meth:`from_arrays`.
        TypeError
            An argument is not an xarray dataset, or a keyword is unknown.
        """
        frames: list[Frame] = []
        stated: dict[str, Any] = {}
        for name, table in zip(CHANNELS, (capture, reference), strict=True):
            if table is None:
                continue
            if not (hasattr(table, "variables") and hasattr(table, "sizes")):
                raise TypeError(f"{name}: expected an xarray.Dataset, found {type(table).__name__}")
            stated |= _known_attributes(table.attrs)
            found = {str(key): item for key, item in table.variables.items() if item.ndim == 1}
            dimensions = sorted({str(item.dims[0]) for item in found.values()})
            if len(dimensions) > 1:
                raise MeasurementError(
                    "format",
                    Path(name),
                    f"expected one dimension, found {', '.join(dimensions)}: select the variables "
                    "of one of them",
                )
            frames.append(
                Frame(
                    name,
                    {key: unpacked(item.values, item.attrs) for key, item in found.items()},
                    {key: item.attrs.get("units") for key, item in found.items()},
                )
            )
        return cls._made(frames, columns, units, {**stated, **metadata})

    @classmethod
    def from_hdf5(
        cls,
        file: Path | str,
        capture: str | None = None,
        reference: str | None = None,
        *,
        columns: Mapping[str, str] | None = None,
        units: Mapping[str, Any] | None = None,
        **metadata: Unpack[Metadata],
    ) -> Self:
        """Make a set from groups of an HDF5 or NeXus file.

        Parameters
        ----------
        file : Path or str
            The file.
        capture : str, optional
            The group whose one-dimensional datasets are the columns of all heads over time, for
            instance ``"/entry/heads"``.
        reference : str, optional
            The group with the errors of head 1 against a reference. If neither group is named,
            ``/capture`` and ``/reference`` are used.
        columns : mapping of str to str, optional
            As in :meth:`from_arrays`.
        units : mapping of str to str or astropy unit, optional
            As in :meth:`from_arrays`; otherwise the attribute ``units`` of a dataset is used.
        **metadata
            As in :meth:`from_arrays`. Attributes of the file and the groups with these names are
            used if a keyword is not given.

        Returns
        -------
        Dataset
            As in :meth:`from_arrays`.

        Raises
        ------
        MeasurementError
            The file or a group is missing or damaged, or as in :meth:`from_arrays`.
        MissingExtraError
            h5py is not installed.
        TypeError
            A keyword is not known.
        """
        h5py = optional("h5py")
        path = Path(file)
        frames: list[Frame] = []
        stated: dict[str, Any] = {}
        try:
            with h5py.File(path, "r") as opened:
                stated |= _known_attributes(opened.attrs)
                wanted = {"capture": capture, "reference": reference}
                if capture is None and reference is None:
                    wanted = {name: name for name in CHANNELS if name in opened}
                    if not wanted:
                        raise MeasurementError(
                            "missing",
                            path,
                            "has neither /capture nor /reference: name the groups, "
                            f"capture='/…'; there are {_groups(h5py, opened)}",
                        )
                for name, place in wanted.items():
                    if place is None:
                        continue
                    group = opened.get(place)
                    if not isinstance(group, h5py.Group):
                        raise MeasurementError(
                            "missing",
                            path,
                            f"has no group {place}; there are {_groups(h5py, opened)}",
                        )
                    stated |= _known_attributes(group.attrs)
                    frames.append(_hdf5_frame(h5py, path, name, group))
        except FileNotFoundError as error:
            raise MeasurementError("missing", path, "no such file") from error
        except OSError as error:
            raise MeasurementError("format", path, f"cannot be read as HDF5: {error}") from error
        return cls._made(frames, columns, units, {**stated, **metadata})

    @classmethod
    def _made(
        cls,
        frames: list[Frame],
        columns: Mapping[str, str] | None,
        units: Mapping[str, Any] | None,
        metadata: Mapping[str, Any],
    ) -> Self:
        if not frames:
            raise TypeError("expected a capture, a reference or both")
        keys = keys_of(metadata)
        columns, units = columns or {}, units or {}
        for name in (*columns, *units):
            _require_name(name, frames, columns)
        found = {
            frame.name: columns_of(
                frame, _of_frame(columns, frame, frames), units, keys.table.counts_per_rev
            )
            for frame in frames
        }
        for name, part in found.items():
            if not all(column.size for column in part.columns.values()):
                raise MeasurementError("empty", Path(name), "has no rows; leave this table out")
        _one_clock(found)
        warnings: list[str] = [text for part in found.values() for text in part.warnings]
        capture = _capture(found["capture"], keys, warnings) if "capture" in found else None
        reference = _reference(found["reference"], keys, warnings) if "reference" in found else None
        for name, rows in (("capture", capture), ("reference", reference)):
            warnings += [] if rows is None else of_zero(rows, name, 0)
        if reference is not None:
            warnings += of_opposite_sign(reference, keys.table, "reference")
        return cls(
            table=keys.table,
            capture=capture,
            reference=reference,
            title=keys.title,
            date=moment(keys.date) if keys.date else None,
            warnings=tuple(warnings),
        )

    @property
    def label(self) -> str:
        """Title of the set, or else the name of its folder."""
        return label_of(self)

    @property
    def sha256(self) -> str:
        """Hash by which the history of a model identifies the set, 64 hexadecimal digits.

        If the folder of the set still holds the same content, this is the hash of its files;
        otherwise it is the hash of the files that :func:`arctrue.write_set` would write.
        """
        return sha256_of(self)

    def __repr__(self) -> str:
        """Return title and number of rows."""
        sizes = {
            "capture": None if self.capture is None else self.capture.run.size,
            "reference": None if self.reference is None else self.reference.error_arcsec.size,
        }
        rows = [f"{name}: {size} rows" for name, size in sizes.items() if size is not None]
        return f"Dataset({', '.join([repr(self.label), *rows] if self.label else rows)})"

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(repr(self))}</p>"


def label_of(measurement: MeasurementSet) -> str:
    """Return the title of a set, or else the name of its folder, as the command line shows it."""
    if measurement.title or measurement.folder is None:
        return measurement.title
    return one_line(measurement.folder.resolve().name)


def sha256_of(measurement: MeasurementSet) -> str:
    """Return the hash of a set in memory as :func:`set_digest` computes it, see
    :attr:`Dataset.sha256`.

    Raises OSError if no temporary folder can be written.
    """
    folder = measurement.folder
    if folder is not None:
        try:
            if _same_rows(read_measurement_set(folder), measurement):
                return set_digest(folder)
        except (MeasurementError, OSError):
            pass
    with tempfile.TemporaryDirectory() as temporary:
        write_measurement_set(temporary, measurement)
        return set_digest(Path(temporary))


def _same_rows(one: MeasurementSet, other: MeasurementSet) -> bool:
    """Tell whether two sets have the same table, title, date, capture and reference run."""
    return _fingerprint(one) == _fingerprint(other)


def _fingerprint(measurement: MeasurementSet) -> bytes:
    digest = hashlib.sha256(repr((measurement.table, measurement.title, measurement.date)).encode())
    for part in (measurement.capture, measurement.reference):
        if part is None:
            digest.update(b"none")
            continue
        for item in fields(part):
            value = getattr(part, item.name)
            digest.update(item.name.encode())
            if isinstance(value, Mapping):
                for name in sorted(value):
                    digest.update(name.encode() + np.ascontiguousarray(value[name]).tobytes())
            elif isinstance(value, np.ndarray):
                digest.update(np.ascontiguousarray(value).tobytes())
            else:
                digest.update(repr(value).encode())
    return digest.digest()


def keys_of(metadata: Mapping[str, Any]) -> Keys:
    """Build the description of the table from the keywords.

    Raises TypeError, MeasurementError.
    """
    content: dict[str, Any] = {"schema": 1, "table": {}, "capture": {}, "reference": {}}
    for name, value in metadata.items():
        if value is None:
            continue
        plain = value.tolist() if hasattr(value, "tolist") else value
        plain = list(plain) if isinstance(plain, tuple) else plain
        if name in TEXTS:
            content[name] = plain.isoformat() if isinstance(plain, date) else plain
        elif name in SECTION_OF:
            content[SECTION_OF[name]][name] = plain
        else:
            known = (*SECTION_OF, *TEXTS)
            raise TypeError(
                f"{name} is not known.{did_you_mean(name, known)} There are: {', '.join(known)}"
            )
    try:
        return typed(content, Keys)
    except ContentError as error:
        raise MeasurementError("value", Path("keywords"), str(error)) from error


def _known_attributes(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the attributes of a file or dataset that are keywords of :class:`Metadata`."""
    found = {}
    for name in (*SECTION_OF, *TEXTS):
        if name in attributes:
            value = attributes[name]
            found[name] = value.decode() if isinstance(value, bytes) else value
    return found


def _groups(h5py: Any, opened: Any) -> str:
    found: list[str] = []

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.ndim == 1:
            parent = "/" + name.rpartition("/")[0]
            if parent not in found:
                found.append(parent)

    opened.visititems(visit)
    return ", ".join(found) or "none with columns of numbers"


def _hdf5_frame(h5py: Any, path: Path, name: str, group: Any) -> Frame:
    """Return the one-dimensional datasets of a group, with the attribute ``units`` of each."""
    columns, units = {}, {}
    datasets = {key: item for key, item in group.items() if isinstance(item, h5py.Dataset)}
    refuse_above_limit(path, sum(item.nbytes for item in datasets.values() if item.ndim == 1))
    for key, item in datasets.items():
        if item.ndim != 1:
            continue
        refuse_other_files(path, item.name.strip("/"), item)
        columns[key] = unpacked(np.asarray(item[()]), item.attrs)
        if "units" in item.attrs:
            units[key] = item.attrs["units"]
    return Frame(name, columns, units)


def unpacked(values: NDArray[Any], attributes: Mapping[str, Any]) -> NDArray[Any]:
    """Return the values that a packed column stands for, with NaN for values that are missing.

    The attributes are those of the CF conventions (cfconventions.org, "Packed Data" and "Missing
    Data"): ``_FillValue``, ``missing_value``, ``scale_factor``, ``add_offset``.
    """
    if values.dtype.kind not in "iuf":
        return values
    given = {
        name: np.ravel(attributes[name])
        for name in ("_FillValue", "missing_value", "scale_factor", "add_offset")
        if name in attributes
    }
    absent = np.zeros(values.shape, dtype=np.bool_)
    for name in ("_FillValue", "missing_value"):
        if name in given and given[name].dtype.kind in "iuf":
            absent |= np.isin(values, given[name])
    if "scale_factor" in given or "add_offset" in given:
        scale, offset = given.get("scale_factor", [1.0]), given.get("add_offset", [0.0])
        values = values.astype(np.float64) * float(scale[0]) + float(offset[0])
    return np.where(absent, np.nan, values) if absent.any() else values


def _require_name(name: str, frames: list[Frame], columns: Mapping[str, str]) -> None:
    """Raise TypeError if ``name`` is neither a quantity nor a column of one of the frames."""
    known = {one for frame in frames for pair in SET_COLUMNS[frame.name].items() for one in pair}
    there = {column for frame in frames for column in frame.columns}
    if name not in known | there:
        raise TypeError(
            f"{name} is neither a quantity nor a column.{did_you_mean(name, known | there)} "
            f"Quantities: {', '.join(sorted(known - there))}"
        )


def _of_frame(columns: Mapping[str, str], frame: Frame, frames: list[Frame]) -> dict[str, str]:
    """Return the entries for this frame: each entry whose column is in this frame or in no other
    frame."""
    if len(frames) == 1:
        return dict(columns)
    others = [other for other in frames if other is not frame]
    return {
        name: column
        for name, column in columns.items()
        if column in frame.columns or not any(column in other.columns for other in others)
    }


_KINDS_OF_DATES: Mapping[str, str] = {
    "utc": "dates without a time zone",
    "zone": "dates with a time zone",
    "duration": "durations",
}


def _one_clock(found: Mapping[str, Found]) -> None:
    """Convert dates to seconds since the earliest date in any of the tables."""
    dated = [part for part in found.values() if part.time_ns is not None and part.time_ns.size]
    if not dated:
        return
    kinds = {part.dates: name for name, part in found.items() if part.dates is not None}
    if len(kinds) > 1:
        one, other = (f"{name} has {_KINDS_OF_DATES[kind]}" for kind, name in kinds.items())
        raise MeasurementError(
            "time",
            Path(next(iter(found))),
            f"{one}, {other}: expected the same in both tables, because a date without a time "
            "zone may be local time",
            column="time_s",
        )
    first = min(int(part.time_ns.min()) for part in dated if part.time_ns is not None)
    for part in dated:
        assert part.time_ns is not None
        part.columns["time_s"] = (part.time_ns - first) * 1e-9


def _capture(found: Found, keys: Keys, warnings: list[str]) -> Capture:
    columns: dict[str, Any] = found.columns
    place = Path("capture")
    require_heads(keys.table, place, columns, Path("keywords"))
    assert keys.table.counts_per_rev is not None
    if "run" not in columns:
        turns = columns["head1_counts"] / keys.table.counts_per_rev
        columns["run"] = np.zeros(turns.size, dtype=np.int64)
        step = turns - np.concatenate(([turns[0]], turns[:-1])) if turns.size else turns
        unwrapped = np.cumsum(step - np.round(step)) if turns.size else turns
        for number, part in enumerate(passes(unwrapped)):
            columns["run"][part.start : part.end] = number
    _in_order(place, columns)
    count_on_past_the_turn(keys.table, place, columns, warnings)
    _require_mask(place, columns)
    return Capture(
        **columns,
        conditions=found.conditions,
        clock_hz=None if keys.capture is None else keys.capture.clock_hz,
    )


def _reference(found: Found, keys: Keys, warnings: list[str]) -> Reference:
    columns: dict[str, Any] = found.columns
    place = Path("reference")
    columns["error_arcsec"], wrapped = without_wraps(
        np.asarray(columns["error_arcsec"], dtype=np.float64)
    )
    if wrapped.size:
        warnings.append(
            f"reference, row {wrapped[0]}: the error differs by whole turns from the other rows, "
            f"as in {wrapped.size} rows in all; these turns are subtracted"
        )
    if "time_s" in columns:
        _in_order(place, columns)
    direction = columns.get("direction")
    if direction is not None and (wrong := np.flatnonzero(np.abs(direction) != 1)).size:
        raise MeasurementError(
            "value",
            place,
            f"row {wrong[0]}: expected +1 (reached upwards) or -1, found {direction[wrong[0]]}",
            column="direction",
        )
    _require_mask(place, columns)
    of_reference = keys.reference
    assert of_reference is not None
    return Reference(
        **columns,
        conditions=found.conditions,
        instrument=of_reference.instrument,
        faces=of_reference.faces,
        standard_uncertainty_arcsec=of_reference.standard_uncertainty_arcsec,
        clock_offset_s=of_reference.clock_offset_s,
    )


def _in_order(place: Path, columns: Mapping[str, NDArray[Any]]) -> None:
    """Raise MeasurementError if the rows of a run are not together, or if time runs backwards in a
    run."""
    time_s = columns["time_s"]
    run = columns.get("run", np.zeros(time_s.size, dtype=np.int64))
    spans = run_spans(run)
    names = [int(run[start]) for start, _ in spans]
    for number, (start, end) in enumerate(spans):
        if names[number] in names[:number]:
            raise MeasurementError(
                "order",
                place,
                f"row {start}: run {names[number]} continues here after another run; sort the "
                "rows by run and time, or give each stretch its own number",
                column="run",
            )
        back = np.flatnonzero(np.diff(time_s[start:end]) < 0.0)
        if back.size:
            row = start + int(back[0]) + 1
            raise MeasurementError(
                "time",
                place,
                f"row {row}: time runs backwards, from {time_s[row - 1]:g} to {time_s[row]:g} s; "
                "sort the rows, or number the runs in a column run",
                column="time_s",
            )


def _require_mask(place: Path, columns: dict[str, Any]) -> None:
    """Convert ``mask`` to Boolean values.

    Raises MeasurementError for a mask other than 0 and 1, and for a negative u.
    """
    mask, u_arcsec = columns.get("mask"), columns.get("u_arcsec")
    if mask is not None:
        wrong = np.flatnonzero((mask != 0) & (mask != 1))
        if wrong.size:
            raise MeasurementError(
                "value",
                place,
                f"row {wrong[0]}: expected 0 or 1 (do not use the row), found {mask[wrong[0]]}",
                column="mask",
            )
        columns["mask"] = mask == 1
    if u_arcsec is not None and (negative := np.flatnonzero(u_arcsec < 0.0)).size:
        raise MeasurementError(
            "value",
            place,
            f"row {negative[0]}: expected 0 or more, found {u_arcsec[negative[0]]:g}",
            column="u_arcsec",
        )
