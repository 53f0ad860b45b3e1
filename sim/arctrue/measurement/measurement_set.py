"""A measurement set in memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from arctrue.base.typed_content import line_of_text

SCHEMA = 1
CAPTURE_COLUMNS = ("run", "time_s", "head1_counts", "head2_counts")
CAPTURE_OPTIONAL = ("temperature_c", "u_arcsec", "mask")
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
"""Columns of truth values."""
WHOLE_COLUMNS = ("run", "head1_counts", "head2_counts", "cycle", "direction", "mask")
"""Whole numbers in 64 bits; all other columns are floats."""
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
"""Of any number of measurement.toml; NaN is not within it."""
AnyNumber = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
NotNegative = Annotated[float, Meta(ge=0, le=LARGEST)]
Positive = Annotated[float, Meta(gt=0, le=LARGEST)]
Count = Annotated[int, Meta(ge=1, le=LARGEST - 1)]


@dataclass(frozen=True)
class Table:
    """The ``[table]`` of measurement.toml; None: not given."""

    counts_per_rev: Annotated[int, Meta(ge=4, le=2**62)] | None = None
    grating_lines: Count | None = None
    disc_diameter_mm: Positive | None = None
    head_separation_deg: Annotated[float, Meta(gt=-360, lt=360)] | None = None
    index_detection_arcsec: Annotated[float, Meta(ge=0, le=3600)] | None = None
    """Standard uncertainty of how far apart the heads detect the same index mark."""
    drive_gear_teeth: Positive | None = None
    faces: Count | None = None
    index_repeatability_counts: NotNegative | None = None
    """How well an index mark repeats from run to run, standard deviation of one head."""


def _column(name: str, value: Any) -> NDArray[Any]:
    """An array (n,) of the column's type. Raises ValueError."""
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
    """What both files have in common: columns of the same length, and keys."""

    __slots__ = ()

    def __post_init__(self) -> None:
        """Make arrays of what is given for the columns: lists, or columns of a data frame.

        Raises ValueError for a column that is no row of numbers, whole ones where they must be,
        or that has another length than the others.
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
        """The same with only the rows where ``kept``, shape (rows,), is True."""
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
    """Both heads over time, arrays (n,); the runs stand one after another.

    ``u_arcsec``: standard uncertainty of R₂ − R₁ in each row. ``mask``: True where the row must
    not be used. ``trusted``: True where the row must be used although it looks like an outlier.
    ``conditions``: further columns of numbers by their names.
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


@dataclass(frozen=True)
class Reference(_Rows):
    """Head 1 against a reference, arrays (n,); None: no such column or key.

    ``u_arcsec``: standard uncertainty of ``error_arcsec`` in each row. ``mask``, ``trusted`` and
    ``conditions`` as in a capture. ``clock_offset_s``: what has to be added to ``time_s`` to get
    the time of the capture.
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
    """How a set was made: the ``command`` that makes it again, and the ``program``'s version.

    ``notes``: what the program decided and what it left out, one sentence each.
    """

    command: str | None = None
    program: str | None = None
    notes: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        """Raises ValueError for more than one line of printable text."""
        notes = [("notes", text) for text in self.notes or ()]
        for key, text in (("command", self.command), ("program", self.program), *notes):
            line_of_text(text or "", key)


@dataclass(frozen=True)
class MeasurementSet:
    """A whole set.

    ``other``: keys that this version does not know, by their dotted names; ``warnings``: what a
    person should be told, one sentence each; ``folder``: where it was read from.
    """

    table: Table
    capture: Capture | None = None
    reference: Reference | None = None
    title: str = ""
    origin: Origin = field(default_factory=Origin)
    other: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    folder: Path | None = None
