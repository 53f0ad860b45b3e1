"""Assigns the columns of the files to the quantities and units of a measurement set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.choices import Ambiguous, Choices
from arctrue.importing.file_content import FileContent
from arctrue.importing.known_names import UNLOCKS, quantity_meant
from arctrue.importing.quantities import (
    HEADS,
    QUANTITIES,
    UNITS,
    Kind,
    may_be_grad,
    name_and_unit,
    unit_named,
)
from arctrue.importing.sexagesimal import OF_DEGREES, is_sexagesimal, sexagesimal
from arctrue.measurement.measurement_set import COLUMNS

LOOKED_AT = 400
"""Number of rows that are examined to find the format of a column."""
NONE = "none"
"""Answer by which the user states that no column contains the quantity."""


@dataclass(frozen=True)
class Source:
    """Source of a quantity: a column and its unit ("" for whole numbers and conditions).
    ``said_by`` names the basis of the assignment: an option, an answer, the column's name or the
    format."""

    column: str
    unit: str
    said_by: str


Mapped = dict[str, Source]
"""Columns of one file: for each quantity or condition, the column that contains it."""


def map_columns(
    recordings: Sequence[FileContent],
    columns: Mapping[str, str],
    units: Mapping[str, str],
    choices: Choices,
) -> list[Mapped]:
    """Find for each file the column of every quantity.

    ``columns`` gives the source by quantity or condition, as ``NAME``, ``NUMBER`` or ``FILE:NAME``;
    columns and files are numbered from 1. ``units`` gives the unit by quantity.

    Raises ValueError for an unknown unit, for a condition with the name of a set's column, for a
    column that does not exist or whose file is unclear, and if no column is left for a quantity.
    Raises AmbiguousError for an open assignment.
    """
    found: list[Mapped] = [{} for _ in recordings]
    for name, unit in units.items():
        kind = QUANTITIES.get(name)
        if kind is None or (unit and unit_named(kind, unit) is None):
            options = "no unit" if kind is None else ", ".join(UNITS[kind])
            raise ValueError(f"--unit {name}={unit}: expected {options}")
    for name, source in columns.items():
        if source == NONE:
            continue
        _refuse_column_of_a_set(name, source)
        places = _places(recordings, name, source)
        for file, column in places:
            unit = _unit(recordings[file], name, column, units, choices)
            found[file][name] = Source(column, unit, "--column")
    for file, recording in enumerate(recordings):
        for name, known in recording.known.items():
            if not any(name in mapped for mapped in found[file : file + 1]) and name not in columns:
                found[file][name] = Source(known.column, known.unit, f"format {recording.format}")
        _by_own_names(recording, found[file], columns, units, choices)
        _by_common_names(recording, found[file], columns, units, choices)
    _ask_for_what_is_needed(recordings, found, columns, units, choices)
    return found


def _refuse_column_of_a_set(name: str, source: str) -> None:
    """Raise ValueError if a condition has the name of a column of a set. The reader would take the
    condition for this column, although its unit is not converted."""
    if name in QUANTITIES or name not in COLUMNS:
        return
    quantity = next((known for known in QUANTITIES if name.startswith(f"{known}_")), None)
    remedy = (
        f"--column {quantity}={source}, and --unit {quantity}=UNIT if the column's name does not "
        "state the unit"
        if quantity
        else "another name"
    )
    raise ValueError(
        f"--column {name}={source}: {name} is a column of a measurement set; use {remedy}"
    )


def _places(recordings: Sequence[FileContent], name: str, source: str) -> list[tuple[int, str]]:
    """Return the index of each file that has the column ``source``, with the column's name
    there."""
    number, colon, rest = source.partition(":")
    if colon and number.isdigit() and 1 <= int(number) <= len(recordings):
        file = int(number) - 1
        column = _column(recordings[file], rest)
        if column is not None:
            return [(file, column)]
    places = [
        (file, column)
        for file, recording in enumerate(recordings)
        if (column := _column(recording, source)) is not None
    ]
    if not places:
        listed = "; ".join(f"{r.path.name}: {_listed(r)}" for r in recordings)
        raise ValueError(f"--column {name}={source}: no such column. Columns: {listed}")
    if 1 < len(places) < len(recordings):
        listed = ", ".join(f"{file + 1}:{column}" for file, column in places)
        raise ValueError(
            f"--column {name}={source}: several files have this column; name one: {listed}"
        )
    return places


def _column(recording: FileContent, source: str) -> str | None:
    if source in recording.columns:
        return source
    names = list(recording.columns)
    if source.isdigit() and 1 <= int(source) <= len(names):
        return names[int(source) - 1]
    return None


def _listed(recording: FileContent) -> str:
    return ", ".join(f"{number} {name}" for number, name in enumerate(recording.columns, start=1))


def _unit(
    recording: FileContent, name: str, column: str, units: Mapping[str, str], choices: Choices
) -> str:
    kind = QUANTITIES.get(name)
    if kind is None or kind == "whole":
        return ""
    if name in units:
        return unit_named(kind, units[name]) or ""
    if kind == "time" and recording.columns[column].dtype.kind == "U":
        return "iso"
    if name in recording.known and recording.known[name].column == column:
        return recording.known[name].unit
    written = name_and_unit(kind, column)[1]
    if written is not None:
        return written
    said, possible = "its name states no unit", [unit for unit in UNITS[kind] if unit != "iso"]
    if kind == "angle" and may_be_grad(column):
        said, possible = "Grad is degrees in German and gon in English", ["deg", "gon"]
    elif kind == "angle" and _has_parts_of_sixty(recording.columns[column]):
        if _surely_degrees(recording.columns[column]):
            choices.note(f"{recording.path.name}: {column} is in degrees, minutes and seconds")
            return "deg"
        said, possible = "it is sexagesimal, in degrees or in hours", ["deg", "hours"]
    return choices.ask(
        Ambiguous(
            "--unit",
            f"{recording.path}, column {column}: {said}.",
            possible,
            key=name,
        )
    )


def _has_parts_of_sixty(values: NDArray[Any]) -> bool:
    """Tell whether the first non-empty text of the column is a sexagesimal number."""
    if values.dtype.kind != "U":
        return False
    return is_sexagesimal(next((text for text in values[:LOOKED_AT] if text.strip()), ""))


def _surely_degrees(values: NDArray[Any]) -> bool:
    """Tell whether a sexagesimal column is in degrees: ° or d in the first row, or a value of 24 or
    more, or of −24 or less."""
    if any(sign in values[0] for sign in OF_DEGREES):
        return True
    return any(abs(sexagesimal(text) or 0.0) >= UNITS["angle"]["hours"] for text in values)


def _by_own_names(
    recording: FileContent,
    found: Mapped,
    columns: Mapping[str, str],
    units: Mapping[str, str],
    choices: Choices,
) -> None:
    """Assign the columns that already have a name of the measurement set; such a column needs no
    --column."""
    for column in recording.columns:
        for name, kind in QUANTITIES.items():
            if name in columns or name in found:
                continue
            base = column if kind == "whole" else name_and_unit(kind, column)[0]
            if base.lower() == name:
                unit = _unit(recording, name, column, units, choices)
                found[name] = Source(column, unit, "its name")


def _by_common_names(
    recording: FileContent,
    found: Mapped,
    columns: Mapping[str, str],
    units: Mapping[str, str],
    choices: Choices,
) -> None:
    """Assign the columns that have a common name of a quantity; if two columns match one quantity,
    assign neither."""
    meant: dict[str, list[str]] = {}
    for column in recording.columns:
        if column in {source.column for source in found.values()} | {*columns.values()}:
            continue
        for name, kind in QUANTITIES.items():
            base, unit = (column, None) if kind == "whole" else name_and_unit(kind, column)
            if quantity_meant(base, unit_of_time=kind == "time" and unit is not None) == name:
                meant.setdefault(name, []).append(column)
    for name, candidates in meant.items():
        if name in columns or name in found or len(candidates) > 1:
            continue
        if _may_be(recording, name, candidates[0], {*found, *meant}):
            unit = _unit(recording, name, candidates[0], units, choices)
            found[name] = Source(candidates[0], unit, "a common name")


def _may_be(recording: FileContent, name: str, column: str, others: set[str]) -> bool:
    """Tell whether a column may contain the quantity ``name``, according to its values and the
    file's other columns."""
    values, kind = recording.columns[column], QUANTITIES[name]
    if kind == "whole":
        whole = values.dtype.kind in "iu"
        return whole and (name != "direction" or bool((np.abs(values) == 1).all()))
    if name == "target":
        # Two heads are compared with each other and need no reference; a commanded angle in the log
        # is not a reference.
        return not {"head1", "head2"} <= others
    if name == "error" and {"target", "head1"} <= others:
        # A column without a unit may contain error codes.
        return name_and_unit(kind, column)[1] is not None
    return values.dtype.kind in "iuf" or kind in ("time", "angle")


def tell_unused(
    recordings: Sequence[FileContent],
    found: Sequence[Mapped],
    columns: Mapping[str, str],
    choices: Choices,
) -> None:
    """Report the unused columns of each file, and the tests that they would permit."""
    for recording, mapped in zip(recordings, found, strict=True):
        used = {source.column for source in mapped.values()}
        unused = [
            f"{number} {column}" + (" (text)" if values.dtype.kind == "U" else "")
            for number, (column, values) in enumerate(recording.columns.items(), start=1)
            if column not in used
        ]
        if not unused:
            continue
        could = [
            f"--column {name}=COLUMN, for {gain}"
            for name, gain in UNLOCKS.items()
            if name not in mapped and columns.get(name) != NONE
        ]
        choices.note(
            f"{recording.path.name}: not used: {', '.join(unused)}. "
            + (f"If one of them is known: {'; '.join(could)}. " if could else "")
            + "--column NAME=COLUMN makes a column a condition, which diagnose then tests"
        )


def _ask_for_what_is_needed(
    recordings: Sequence[FileContent],
    found: list[Mapped],
    columns: Mapping[str, str],
    units: Mapping[str, str],
    choices: Choices,
) -> None:
    def there(name: str) -> bool:
        return any(name in mapped for mapped in found)

    def ask(name: str, what: str, *, may_lack: bool) -> None:
        if there(name) or columns.get(name) == NONE:
            return
        several = len(recordings) > 1
        numbered = {
            f"{file + 1}:{number}" if several else str(number): f"{file + 1}:{column}"
            if several
            else column
            for file, recording in enumerate(recordings)
            for number, column in enumerate(recording.columns, start=1)
            if column not in {source.column for source in found[file].values()}
        }
        options = [*numbered.values()]
        listed = "; ".join(f"{r.path.name} has {_listed(r)}" for r in recordings)
        if not options and not may_lack:
            raise ValueError(f"no remaining column could be {what}: {listed}")
        timed = (
            " For times and errors without an angle, give --column time=…, --column error=… and "
            "--rate."
            if name == "target" and not there("head1")
            else ""
        )
        asked = Ambiguous(
            "--column",
            f"Which column is {what}? {listed}.{timed}",
            [*options, NONE] if may_lack else options,
            numbered=numbered,
            key=name,
        )
        given = choices.ask(asked)
        if given != NONE:
            for file, column in _places(recordings, name, given):
                unit = _unit(recordings[file], name, column, units, choices)
                found[file][name] = Source(column, unit, "answer")

    if not there("target") and any(timed_error(mapped) for mapped in found):
        return
    if not (there("head1") and there("head2")):
        ask("target", "the angle by the reference (target)", may_lack=True)
    if there("target") and not there("error"):
        if not there("head1"):
            ask("error", "the error (reading minus target, or target minus reading)", may_lack=True)
        if not there("error"):
            ask("head1", "the reading of the encoder (head1)", may_lack=False)
    if not there("target"):
        ask("head1", "the reading of head 1", may_lack=False)
        ask("head2", "the reading of head 2", may_lack=False)
        if not all("time" in mapped for mapped in found if "head1" in mapped):
            ask("time", "the time", may_lack=False)


def timed_error(mapped: Mapped) -> bool:
    """Tell whether a file has times and errors but no angle, so that the speed of the axis gives
    its angle."""
    return {"time", "error"} <= set(mapped) and not {"target", *HEADS} & set(mapped)


def numbers(recording: FileContent, source: Source) -> NDArray[np.int64] | NDArray[np.float64]:
    """Return the column as finite numbers, with NaN for a missing value. Raises MeasurementError
    for any other field."""
    values = recording.columns[source.column]
    if values.dtype.kind in "iu":
        return values.astype(np.int64)
    if values.dtype.kind == "b":
        return values.astype(np.int64)
    if values.dtype.kind == "f":
        infinite = np.flatnonzero(np.isinf(values))
        if infinite.size:
            raise recording.fault(
                "expected a finite number, found inf", int(infinite[0]), source.column
            )
        return values.astype(np.float64)
    # A column in degrees or hours may be sexagesimal: 12:34:56.7.
    sixty = source.unit in ("deg", "hours")
    found = np.empty(values.size)
    for row, text in enumerate(values.tolist()):
        number = _number(str(text), sixty=sixty)
        if number is None:
            row = _wrong_row(values, row, sixty=sixty)
            raise recording.fault(
                f"expected a number, found {str(values[row])!r}", row, source.column
            )
        found[row] = number
    return found


def _wrong_row(values: NDArray[Any], first: int, *, sixty: bool) -> int:
    """Return the first row whose text is not a number, even if commas are read as decimal signs or
    as separators of thousands.

    ``first`` is the first row whose text is not a number without this reading of commas.
    """
    for row, text in enumerate(values[first:].tolist(), start=first):
        if all(_number(str(text).replace(",", sign), sixty=sixty) is None for sign in (".", "")):
            return row
    return first


def _number(text: str, *, sixty: bool) -> float | None:
    """Return a text as a number; NaN for a missing number, None for infinity and other texts."""
    if not text.strip():
        return np.nan
    try:
        if "_" not in text and np.isfinite(number := float(text)):
            return number
    except ValueError:
        return sexagesimal(text) if sixty else None
    return None


DAY_S = 86400.0


def seconds(recording: FileContent, source: Source) -> NDArray[np.float64]:
    """Return times in seconds since 1970, since the start of the log, or since midnight; NaN for a
    missing time."""
    values = recording.columns[source.column]
    if source.unit != "iso":
        return np.asarray(numbers(recording, source) / UNITS["time"][source.unit], dtype=np.float64)
    found = np.empty(values.size, dtype=np.float64)
    of_day = missing = 0
    for row, text in enumerate(values.tolist()):
        hours = sexagesimal(str(text))
        try:
            if hours is not None:
                found[row] = hours * 3600.0
                of_day += 1
            elif not str(text).strip():
                found[row] = np.nan
                missing += 1
            else:
                moment = datetime.fromisoformat(str(text).strip().replace(",", "."))
                # A time without a time zone is taken as UTC, because only differences matter.
                found[row] = moment.replace(tzinfo=moment.tzinfo or UTC).timestamp()
        except ValueError:
            raise recording.fault(
                "expected a time such as 2026-01-31T12:00:00.125 or 12:00:00.125, found "
                f"{text!r}; --column time=none ignores the time",
                row,
                source.column,
            ) from None
    if of_day == found.size - missing:
        # Times of day get one more day after each midnight, so that they continue to rise.
        there = np.flatnonzero(~np.isnan(found))
        found[there[1:]] += DAY_S * np.cumsum(np.diff(found[there]) < -0.5 * DAY_S)
    return found


def kind_of(name: str) -> Kind | None:
    """Return the kind of a quantity; None for a condition."""
    return QUANTITIES.get(name)
