"""Builds measurement sets from pandas, xarray, HDF5, and dictionaries of arrays."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Self, Unpack

from arctrue.api.frame import Frame
from arctrue.api.keywords import Metadata
from arctrue.api.library_frames import given, hdf5_frames, pandas_frame, xarray_frames
from arctrue.api.set_hash import sha256_of
from arctrue.api.set_of_frames import set_of_frames
from arctrue.base.printable import one_line
from arctrue.measurement import MeasurementSet, read_measurement_set


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
            [Frame(name, dict(table)) for name, table in given(capture, reference).items()],
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
        frames = [pandas_frame(name, table) for name, table in given(capture, reference).items()]
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
        frames, stated = xarray_frames(given(capture, reference))
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
        frames, stated = hdf5_frames(Path(file), given(capture, reference))
        return cls._made(frames, columns, units, {**stated, **metadata})

    @classmethod
    def _made(
        cls,
        frames: list[Frame],
        columns: Mapping[str, str] | None,
        units: Mapping[str, Any] | None,
        metadata: Mapping[str, Any],
    ) -> Self:
        return cls.of(set_of_frames(frames, columns or {}, units or {}, metadata))

    @property
    def label(self) -> str:
        """Title of the set, or else the name of its folder."""
        if self.title or self.folder is None:
            return self.title
        return one_line(self.folder.resolve().name)

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
