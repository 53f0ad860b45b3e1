"""Converts the quantities of one file to common units: angles in turns, times in seconds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.importing.choices import Choices
from arctrue.importing.columns import Mapped, kind_of, numbers, seconds
from arctrue.importing.file_content import FileContent
from arctrue.importing.motion import without_jumps
from arctrue.importing.quantities import HEADS, UNITS

Integer = NDArray[np.int64]
Float = NDArray[np.float64]

KELVIN_AT_0 = 273.15
FAHRENHEIT_AT_0 = 32.0


@dataclass(frozen=True)
class FileRows:
    """Holds the rows of one file in common units, one array (rows,) for each quantity.

    ``exact`` contains the readings of those heads whose column has whole counts.
    """

    recording: FileContent
    sources: Mapped
    kept: Integer
    angles: Mapping[str, Float]
    exact: Mapping[str, Integer]
    time_s: Float | None = None
    whole: Mapping[str, Integer] = field(default_factory=dict)
    temperature_c: Float | None = None
    conditions: Mapping[str, Float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The file's name."""
        return self.recording.path.name

    @property
    def instrument(self) -> str | None:
        """The reference instrument that the file names."""
        return self.recording.instrument

    def line(self, row: int) -> int:
        """Return the file's line number of a row; ``row`` counts from 0."""
        return self.recording.line(int(self.kept[row]))

    def fault(self, message: str, row: int, quantity: str) -> Exception:
        """Return a MeasurementError that names file, row and column."""
        return self.recording.fault(message, int(self.kept[row]), self.sources[quantity].column)

    def where(self, wanted: NDArray[np.bool_]) -> Self:
        """Return the rows for which ``wanted`` is True."""
        return self.taken(wanted)

    def taken(self, wanted: NDArray[Any]) -> Self:
        """Return the rows for which a Boolean ``wanted`` is True, or the rows with the indices
        ``wanted`` in this order."""

        def part(values: Mapping[str, Any]) -> dict[str, Any]:
            return {name: column[wanted] for name, column in values.items()}

        return replace(
            self,
            kept=self.kept[wanted],
            angles=part(self.angles),
            exact=part(self.exact),
            time_s=None if self.time_s is None else self.time_s[wanted],
            whole=part(self.whole),
            temperature_c=None if self.temperature_c is None else self.temperature_c[wanted],
            conditions=part(self.conditions),
        )

    def unwrapped(self, quantity: str, choices: Choices, angle: Float | None = None) -> Float:
        """Return the angle in turns, without a restart at the end of a turn."""
        found, wraps = without_jumps(self.angles[quantity] if angle is None else angle)
        if wraps:
            choices.note(f"{self.name}: {quantity} restarts {wraps} times at the end of a turn")
        return found

    def counts(self, quantity: str, counts_per_rev: int) -> Integer:
        """Return the angle in whole counts."""
        if quantity in self.exact:
            return self.exact[quantity]
        return np.round(self.angles[quantity] * counts_per_rev).astype(np.int64)

    def further(self) -> dict[str, Any]:
        """Return temperature, uncertainty and mask by name, and each condition by ``=`` followed by
        its name."""
        found: dict[str, Any] = {f"={name}": values for name, values in self.conditions.items()}
        if self.temperature_c is not None:
            found["temperature_c"] = self.temperature_c
        if "u" in self.angles:
            found["u_arcsec"] = self.angles["u"] * ARCSEC_PER_TURN
        if "mask" in self.whole:
            found["mask"] = self.whole["mask"] != 0
        return found


def rows_of(
    recording: FileContent,
    sources: Mapped,
    counts_per_rev: int | None,
    missing: str,
    choices: Choices,
) -> FileRows:
    """Convert the mapped columns of a file to common units.

    Raises MeasurementError for a missing value; if ``missing`` is ``drop``, rows with a missing
    value are left out instead, and a note states this. Raises MeasurementError also for a field
    that is not a number, a fraction in a column of whole numbers, a direction other than ±1, and if
    no row has all values.
    """
    raw: dict[str, Any] = {}
    complete = np.ones(recording.rows, dtype=bool)
    for quantity, source in sources.items():
        values = (
            seconds(recording, source)
            if kind_of(quantity) == "time"
            else numbers(recording, source)
        )
        gaps = np.isnan(values) if values.dtype.kind == "f" else np.zeros(values.size, dtype=bool)
        if gaps.any() and missing != "drop":
            raise recording.fault(
                "the value is missing; --missing drop leaves such rows out",
                int(np.flatnonzero(gaps)[0]),
                source.column,
            )
        complete &= ~gaps
        raw[quantity] = values
    if not complete.all():
        choices.note(
            f"{recording.path.name}: {int((~complete).sum())} rows with missing values are left out"
        )
    if not complete.any():
        raise recording.fault("no row has all values")
    kept = np.flatnonzero(complete)
    rows = FileRows(recording, sources, kept, {}, {})
    angles: dict[str, Float] = {}
    exact: dict[str, Integer] = {}
    whole: dict[str, Integer] = {}
    conditions: dict[str, Float] = {}
    for quantity, values in raw.items():
        column = values if kept.size == recording.rows else values[complete]
        kind, unit = kind_of(quantity), sources[quantity].unit
        if kind == "angle":
            per_turn = float(counts_per_rev or 1) if unit == "counts" else UNITS["angle"][unit]
            angles[quantity] = column / per_turn
            if unit == "counts" and quantity in HEADS:
                exact[quantity] = _whole(rows, quantity, column)
        elif kind == "whole":
            whole[quantity] = _whole(rows, quantity, column)
        elif kind == "time":
            rows = replace(rows, time_s=column)
        elif kind == "temperature":
            rows = replace(rows, temperature_c=_celsius(column.astype(np.float64), unit))
        else:
            conditions[quantity] = column.astype(np.float64)
    if "direction" in whole:
        wrong = np.flatnonzero(np.abs(whole["direction"]) != 1)
        if wrong.size:
            found = whole["direction"][wrong[0]]
            raise rows.fault(f"expected +1 or -1, found {found}", int(wrong[0]), "direction")
    return replace(rows, angles=angles, exact=exact, whole=whole, conditions=conditions)


def _whole(rows: FileRows, quantity: str, column: NDArray[Any]) -> Integer:
    found = column.astype(np.int64)
    wrong = np.flatnonzero(found != column)
    if wrong.size:
        place = int(wrong[0])
        raise rows.fault(f"expected a whole number, found {column[place]:g}", place, quantity)
    return found


def _celsius(values: Float, unit: str) -> Float:
    if unit == "K":
        return values - KELVIN_AT_0
    return (values - FAHRENHEIT_AT_0) / UNITS["temperature"]["degF"] if unit == "degF" else values
