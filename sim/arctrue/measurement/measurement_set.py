"""Holds a measurement set in memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from arctrue.base.typed_content import line_of_text

SCHEMA = 1
CAPTURE_COLUMNS = ("run", "time_s", "head1_counts", "head2_counts")
FURTHER_HEADS = ("head3_counts", "head4_counts")
"""Columns that a capture has only with three or four heads."""
HEAD_COLUMNS = ("head1_counts", "head2_counts", *FURTHER_HEADS)
CAPTURE_OPTIONAL = (*FURTHER_HEADS, "temperature_c", "u_arcsec", "mask")
REFERENCE_COLUMNS = ("target_deg", "error_arcsec")
REFERENCE_OPTIONAL = (
    "run",
    "time_s",
    "cycle",
    "direction",
    "head1_counts",
    "temperature_c",
    "u_arcsec",
    "mask",
)
TRUTHS = ("mask", "trusted")
"""Columns of Boolean values."""
WHOLE_COLUMNS = (
    "run",
    "head1_counts",
    "head2_counts",
    *FURTHER_HEADS,
    "cycle",
    "direction",
    "mask",
)
"""Columns of 64-bit integers; all other columns are floats."""
COLUMNS = {
    *CAPTURE_COLUMNS,
    *CAPTURE_OPTIONAL,
    *REFERENCE_COLUMNS,
    *REFERENCE_OPTIONAL,
    *TRUTHS,
}

Integer = NDArray[np.int64]
Float = NDArray[np.float64]
Boolean = NDArray[np.bool_]


LARGEST = 2**63
"""Limit of the absolute value of a number in measurement.toml; with this limit NaN is refused,
too."""
AnyNumber = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
NotNegative = Annotated[float, Meta(ge=0, le=LARGEST)]
Positive = Annotated[float, Meta(gt=0, le=LARGEST)]
Count = Annotated[int, Meta(ge=1, le=LARGEST - 1)]
HeadPlace = Annotated[float, Meta(gt=-360, lt=360)]


@dataclass(frozen=True)
class Table:
    """The section ``[table]`` of measurement.toml; None stands for a key that is not stated.

    Parameters
    ----------
    counts_per_rev : int, optional
        Number of counts per turn.
    grating_lines : int, optional
        Number of lines of the disc.
    disc_diameter_mm : float, optional
        Diameter of the circle of lines, mm.
    head_separation_deg : float, optional
        Angle from head 1 to head 2, degrees.
    index_detection_arcsec : float, optional
        Standard uncertainty of the distance between the places where the heads detect the index
        mark, arcseconds.
    drive_gear_teeth : float, optional
        Number of teeth of the gear that drives the table; it may be fractional.
    faces : int, optional
        Number of faces of the polygon that the reference runs used.
    index_repeatability_counts : float, optional
        Standard deviation of one head's index mark from run to run, counts.
    head_places_deg : tuple of float, optional
        Angles of all heads relative to head 1, degrees, beginning with 0 for head 1; in place of
        ``head_separation_deg``.
    """

    counts_per_rev: Annotated[int, Meta(ge=4, le=2**62)] | None = None
    grating_lines: Count | None = None
    disc_diameter_mm: Positive | None = None
    head_separation_deg: HeadPlace | None = None
    """Angle of head 2 relative to head 1, degrees; the second entry of ``head_places_deg`` if this
    key is given."""
    index_detection_arcsec: Annotated[float, Meta(ge=0, le=3600)] | None = None
    """Standard uncertainty of the angle between the places at which the two heads detect the index
    mark, arcseconds."""
    drive_gear_teeth: Positive | None = None
    faces: Count | None = None
    index_repeatability_counts: NotNegative | None = None
    """Standard deviation of one head's index mark from run to run, counts."""
    head_places_deg: Annotated[tuple[HeadPlace, ...], Meta(min_length=2, max_length=4)] | None = (
        None
    )
    """Angles of all heads relative to head 1, degrees; the first is 0. They replace
    ``head_separation_deg``."""

    def __post_init__(self) -> None:
        """Set ``head_separation_deg`` to the second entry of ``head_places_deg``, if this is given.

        Raises ValueError if the places do not begin at 0, if two places coincide, or if another
        separation is stated.
        """
        places, separation = self.head_places_deg, self.head_separation_deg
        if places is None:
            return
        if places[0] != 0.0:
            raise ValueError(
                f"head_places_deg: expected 0 for head 1, because all places are relative to head "
                f"1, found {places[0]:g}"
            )
        turned = sorted(place % 360.0 for place in places)
        if len(set(turned)) < len(turned):
            raise ValueError(
                f"head_places_deg: expected a place of its own for every head, found {list(places)}"
            )
        if separation is not None and separation != places[1]:
            raise ValueError(
                f"head_separation_deg: expected {places[1]:g}, the place of head 2 in "
                f"head_places_deg, found {separation:g}; leave out head_separation_deg"
            )
        object.__setattr__(self, "head_separation_deg", places[1])

    @property
    def places_deg(self) -> tuple[float, ...] | None:
        """Angles of all heads relative to head 1, degrees; None if the set states no separation."""
        if self.head_places_deg is not None:
            return self.head_places_deg
        separation = self.head_separation_deg
        return None if separation is None else (0.0, separation)


def _column(name: str, value: Any) -> NDArray[Any]:
    """Return an array (n,) of the column's type. Raises ValueError if a value does not fit the
    type."""
    array = np.asarray(value)
    if array.ndim != 1:
        raise ValueError(f"{name}: expected a row of numbers, found an array {array.shape}")
    kind = np.bool_ if name in TRUTHS else np.int64 if name in WHOLE_COLUMNS else np.float64
    if array.dtype == kind:
        return array
    try:
        found = array.astype(kind)
        wrong = np.flatnonzero(found != array) if kind != np.float64 else np.array([], np.int64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected numbers, found {array.dtype}: {error}") from None
    if wrong.size:
        expected = "0 or 1" if name in TRUTHS else "whole numbers"
        raise ValueError(f"{name}[{wrong[0]}]: expected {expected}, found {array[int(wrong[0])]}")
    return found


class _Rows:
    """Holds the rows of one file in columns of equal length, and the keys of the file's section."""

    __slots__ = ()

    def __post_init__(self) -> None:
        """Convert the given columns, which may be lists or columns of a data frame, to arrays.

        Raises ValueError for a column that is not one-dimensional and numeric, that has fractions
        where integers are required, or whose length differs from that of the others.
        """
        sizes: dict[str, int] = {}
        for item in fields(self):  # type: ignore[arg-type]
            value = getattr(self, item.name)
            if item.name in COLUMNS and value is not None:
                array = _column(item.name, value)
                object.__setattr__(self, item.name, array)
                sizes[item.name] = array.size
        conditions: Mapping[str, Any] = self.conditions  # type: ignore[attr-defined]
        arrays = {name: _column(name, value) for name, value in conditions.items()}
        object.__setattr__(self, "conditions", arrays)
        sizes |= {name: array.size for name, array in arrays.items()}
        if len(set(sizes.values())) > 1:
            listed = ", ".join(f"{name} {size}" for name, size in sizes.items())
            raise ValueError(f"the columns must be equally long, found {listed}")

    def where(self, kept: Boolean) -> Self:
        """Return only some of the rows.

        Parameters
        ----------
        kept : ndarray of bool, shape (rows,)
            True in each row to return.

        Returns
        -------
        Capture or Reference
            The same kind of rows.
        """
        values: dict[str, Any] = {}
        for item in fields(self):  # type: ignore[arg-type]
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray):
                value = value[kept]
            elif isinstance(value, Mapping):
                value = {name: column[kept] for name, column in value.items()}
            values[item.name] = value
        return type(self)(**values)


@dataclass(frozen=True)
class Capture(_Rows):
    """Readings of all heads over time; the runs are stored one after another.

    Parameters
    ----------
    run : ndarray of int, shape (rows,)
        Number of the run; a run has one direction.
    time_s : ndarray, shape (rows,)
        Time, s; within a run it never decreases.
    head1_counts : ndarray of int, shape (rows,)
        Reading of head 1, counts; it continues past a turn.
    head2_counts : ndarray of int, shape (rows,)
        Reading of head 2, counts.
    temperature_c : ndarray, shape (rows,), optional
        Temperature, °C.
    clock_hz : float, optional
        Clock of the gateware, Hz.
    u_arcsec : ndarray, shape (rows,), optional
        Standard uncertainty of R₂ − R₁ in each row, arcseconds.
    mask : ndarray of bool, shape (rows,), optional
        True where the row must not be used.
    trusted : ndarray of bool, shape (rows,), optional
        True where the row must be used although it looks like an outlier.
    conditions : mapping of str to ndarray, shape (rows,), optional
        Further columns of numbers by their names, in their own units.
    head3_counts : ndarray of int, shape (rows,), optional
        Reading of head 3, counts.
    head4_counts : ndarray of int, shape (rows,), optional
        Reading of head 4, counts.
    """

    run: Integer
    time_s: Float
    head1_counts: Integer
    head2_counts: Integer
    temperature_c: Float | None = None
    clock_hz: float | None = None
    u_arcsec: Float | None = None
    mask: Boolean | None = None
    trusted: Boolean | None = None
    conditions: Mapping[str, Float] = field(default_factory=dict)
    head3_counts: Integer | None = None
    head4_counts: Integer | None = None

    def __post_init__(self) -> None:
        """Check the columns.

        Raises ValueError for the faults that the base class finds, and for a head 4 without head 3.
        """
        super().__post_init__()
        if self.head4_counts is not None and self.head3_counts is None:
            raise ValueError("head4_counts: expected head3_counts too, which is missing")

    @property
    def heads(self) -> tuple[Integer, ...]:
        """Readings of all heads in counts; head 1 is the first."""
        further = (self.head3_counts, self.head4_counts)
        return (self.head1_counts, self.head2_counts, *(h for h in further if h is not None))


@dataclass(frozen=True)
class Reference(_Rows):
    """Comparison of head 1 with a reference; None stands for a column or key that is missing.

    Parameters
    ----------
    target_deg : ndarray, shape (rows,)
        Target angle, degrees.
    error_arcsec : ndarray, shape (rows,)
        Reading of head 1 minus the angle by the reference, arcseconds.
    run : ndarray of int, shape (rows,), optional
        Number of the run.
    time_s : ndarray, shape (rows,), optional
        Time, s.
    cycle : ndarray of int, shape (rows,), optional
        Number of the cycle.
    direction : ndarray of int, shape (rows,), optional
        Direction of approach: 1 upwards, -1 downwards.
    head1_counts : ndarray of int, shape (rows,), optional
        Reading of head 1, counts.
    temperature_c : ndarray, shape (rows,), optional
        Temperature, °C.
    instrument : str, optional
        Description of the reference instrument, one line.
    faces : int, optional
        Number of faces of the polygon.
    standard_uncertainty_arcsec : float, optional
        Standard uncertainty of the reference, arcseconds.
    clock_offset_s : float, optional
        Offset that converts ``time_s`` to the time of the capture, s.
    u_arcsec : ndarray, shape (rows,), optional
        Standard uncertainty of ``error_arcsec`` in each row, arcseconds.
    mask : ndarray of bool, shape (rows,), optional
        True where the row must not be used.
    trusted : ndarray of bool, shape (rows,), optional
        True where the row must be used although it looks like an outlier.
    conditions : mapping of str to ndarray, shape (rows,), optional
        Further columns of numbers by their names, in their own units.
    """

    target_deg: Float
    error_arcsec: Float
    run: Integer | None = None
    time_s: Float | None = None
    cycle: Integer | None = None
    direction: Integer | None = None
    head1_counts: Integer | None = None
    temperature_c: Float | None = None
    instrument: str | None = None
    faces: int | None = None
    standard_uncertainty_arcsec: float | None = None
    clock_offset_s: float | None = None
    u_arcsec: Float | None = None
    mask: Boolean | None = None
    trusted: Boolean | None = None
    conditions: Mapping[str, Float] = field(default_factory=dict)


@dataclass(frozen=True)
class Origin:
    """The command and the program that made a set, and the notes of the program.

    Parameters
    ----------
    command : str, optional
        The command that generates the set again, one line.
    program : str, optional
        Name and version of the program.
    notes : tuple of str, optional
        Decisions and omissions of the program, one sentence each.
    """

    command: str | None = None
    program: str | None = None
    notes: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        """Check the texts. Raises ValueError for a text of more than one printable line."""
        notes = [("notes", text) for text in self.notes or ()]
        for key, text in (("command", self.command), ("program", self.program), *notes):
            line_of_text(text or "", key)


@dataclass(frozen=True)
class MeasurementSet:
    """Holds a whole measurement set.

    Parameters
    ----------
    table : Table
        Description of the table: counts per turn, heads, disc, gear.
    capture : Capture, optional
        Readings of all heads over time.
    reference : Reference, optional
        Comparison of head 1 with a reference.
    title : str, optional
        Name of the set, one line.
    origin : Origin, optional
        Command and program that made the set.
    other : mapping, optional
        Keys that this version does not know, by their dotted names.
    warnings : tuple of str, optional
        Warnings about the data, one sentence each.
    folder : Path, optional
        The folder from which the set was read.
    date : datetime, optional
        Time of the measurement, with its time zone.
    """

    table: Table
    capture: Capture | None = None
    reference: Reference | None = None
    title: str = ""
    origin: Origin = field(default_factory=Origin)
    other: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    folder: Path | None = None
    date: datetime | None = None
