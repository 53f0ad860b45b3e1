"""Converts named columns of other libraries' tables to the columns and units of a measurement set.

A column is found by the name that the caller gives, by its name in a measurement set, or by a
common name (``arctrue.importing.known_names``). The unit of a column is given by the caller, stated
by the column itself (astropy, xarray, HDF5), or stated at the end of the column's name
(``az_deg``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.base.similar import did_you_mean
from arctrue.importing.file_rows import FAHRENHEIT_AT_0, KELVIN_AT_0
from arctrue.importing.known_names import quantity_meant
from arctrue.importing.quantities import QUANTITIES, UNITS, Kind, name_and_unit, unit_named
from arctrue.measurement import MeasurementError

SET_COLUMNS: Mapping[str, Mapping[str, str]] = {
    "capture": {
        "run": "run",
        "time": "time_s",
        "head1": "head1_counts",
        "head2": "head2_counts",
        "head3": "head3_counts",
        "head4": "head4_counts",
        "temperature": "temperature_c",
        "u": "u_arcsec",
        "mask": "mask",
    },
    "reference": {
        "target": "target_deg",
        "error": "error_arcsec",
        "run": "run",
        "time": "time_s",
        "cycle": "cycle",
        "direction": "direction",
        "head1": "head1_counts",
        "temperature": "temperature_c",
        "u": "u_arcsec",
        "mask": "mask",
    },
}
"""Name of the measurement set's column for each quantity, by channel."""
REQUIRED: Mapping[str, tuple[str, ...]] = {
    "capture": ("time", "head1", "head2"),
    "reference": ("target", "error"),
}
_OTHER_SPELLINGS = {"deg_C": "degC", "ct": "counts"}
"""Units whose astropy name differs from the name here, by astropy name."""


Dates = Literal["utc", "zone", "duration"]
"""Kinds of dates: without a time zone, which means UTC; with a time zone; durations."""


@dataclass(frozen=True)
class Frame:
    """Holds the named columns of a table of any library.

    ``columns``: one-dimensional arrays of equal length, by name. ``units``: units that the table
    itself states. ``name``: the channel, for messages.
    """

    name: str
    columns: Mapping[str, Any]
    units: Mapping[str, Any] = field(default_factory=dict)


@dataclass
class Found:
    """Columns and conditions in a measurement set's form, and warnings about unused columns."""

    columns: dict[str, NDArray[Any]]
    conditions: dict[str, NDArray[np.float64]]
    warnings: list[str]
    time_ns: NDArray[np.int64] | None = None
    """Dates of the rows in nanoseconds since 1970, if the time is a date or a duration."""
    dates: Dates | None = None
    """Kind of these dates."""


def columns_of(
    frame: Frame,
    columns: Mapping[str, str],
    units: Mapping[str, Any],
    counts_per_rev: int | None,
) -> Found:
    """Return the columns of ``frame`` in the units of a measurement set.

    ``columns``: the frame's column for each quantity, or for each column of a set. ``units``: the
    unit, by quantity or by column. Raises MeasurementError, which names the column, the expected
    content and the remedy.
    """
    places = _places(frame, columns)
    found: dict[str, NDArray[Any]] = {}
    time_ns, dates = None, None
    for quantity, column in places.items():
        set_column = SET_COLUMNS[frame.name][quantity]
        values, kind = frame.columns[column], QUANTITIES[quantity]
        _refuse_masked(frame, column, values)
        if kind == "time" and (read := _dates(frame, column, values)) is not None:
            time_ns, dates = read
            found[set_column] = np.zeros(time_ns.size)
            continue
        if kind == "whole":
            found[set_column] = _whole(frame, column, _numbers(frame, column, values))
            continue
        unit = _unit(frame, quantity, column, units)
        found[set_column] = _converted(frame, quantity, column, unit, counts_per_rev)
    conditions: dict[str, NDArray[np.float64]] = {}
    warnings = []
    for column, values in frame.columns.items():
        if column in places.values() or columns.get(column) == "":
            continue
        array = np.asarray(getattr(values, "value", values))
        whole = array.dtype.kind in "iufb" and not _masked(values).any()
        if whole and bool(np.isfinite(array).all()):
            conditions[column] = array.astype(np.float64)
        else:
            warnings.append(
                f"{frame.name}: column {column} is not used: not all of its values are finite "
                "numbers"
            )
    return Found(found, conditions, warnings, time_ns, dates)


def _places(frame: Frame, columns: Mapping[str, str]) -> dict[str, str]:
    """Find the frame's column of each quantity."""
    of_set = SET_COLUMNS[frame.name]
    found: dict[str, str] = {}
    for name, column in columns.items():
        quantity = next((q for q, own in of_set.items() if name in (q, own)), None)
        if quantity is None or column == "":
            continue
        if column not in frame.columns:
            raise _fault(
                frame,
                str(column),
                f"is given for {name} but does not "
                f"exist.{did_you_mean(str(column), frame.columns)} "
                f"There are: {', '.join(map(str, frame.columns))}",
            )
        twice = next((other for other, one in found.items() if one == column), None)
        if twice not in (None, quantity):
            raise _fault(
                frame, str(column), f"is given for {twice} and for {quantity}; expected one of them"
            )
        found[quantity] = column
    for quantity, own in of_set.items():
        if quantity not in found and own in frame.columns and own not in found.values():
            found[quantity] = own
    for quantity in of_set:
        if quantity in found:
            continue
        candidates = [c for c in frame.columns if c not in found.values() and _means(c, quantity)]
        if len(candidates) > 1:
            raise _fault(
                frame,
                quantity,
                f"may be any of {', '.join(candidates)}: state which, columns={{'{quantity}': "
                f"'{candidates[0]}'}}",
            )
        if candidates:
            found[quantity] = candidates[0]
    for quantity in REQUIRED[frame.name]:
        if quantity not in found:
            raise _fault(
                frame,
                of_set[quantity],
                f"is missing; there are {', '.join(map(str, frame.columns)) or 'no columns'}. "
                f"State which of them it is: columns={{'{quantity}': 'NAME'}}",
                missing=True,
            )
    return found


def _means(column: str, quantity: str) -> bool:
    kind = QUANTITIES[quantity]
    base, unit = (column, None) if kind == "whole" else name_and_unit(kind, column)
    if base.lower() == quantity:
        return True
    return quantity_meant(base, unit_of_time=kind == "time" and unit is not None) == quantity


def _unit(frame: Frame, quantity: str, column: str, units: Mapping[str, Any]) -> Any:
    """Return the unit that the caller gives or, without it, the unit of the column itself or the
    unit in the column's name."""
    kind = QUANTITIES[quantity]
    for name in (quantity, SET_COLUMNS[frame.name][quantity], column):
        if name in units:
            return _known(frame, quantity, column, units[name])
    values = frame.columns[column]
    if hasattr(values, "unit") and hasattr(values, "to_value"):
        return values.unit
    if frame.units.get(column):
        return _known(frame, quantity, column, frame.units[column])
    written = name_and_unit(kind, column)[1]
    if written is not None:
        return written
    raise _fault(
        frame,
        column,
        f"its unit is not known; expected one of {_units(kind)}: units={{'{quantity}': "
        f"'{next(iter(UNITS[kind]))}'}}, or a name that ends with the unit ({quantity}_"
        f"{next(iter(UNITS[kind]))})",
    )


def _units(kind: Kind) -> str:
    return ", ".join(unit for unit in UNITS[kind] if unit != "iso")


def _known(frame: Frame, quantity: str, column: str, unit: Any) -> Any:
    """Return the name of the unit; a unit of astropy is returned unchanged."""
    if not isinstance(unit, str) and hasattr(unit, "to") and hasattr(unit, "physical_type"):
        return unit
    kind = QUANTITIES[quantity]
    text = str(unit.decode() if isinstance(unit, bytes) else unit)
    named = unit_named(kind, _OTHER_SPELLINGS.get(text, text))
    if named is None or named == "iso":
        raise _fault(frame, column, f"expected a unit of {kind} ({_units(kind)}), found {text!r}")
    return named


def _converted(
    frame: Frame, quantity: str, column: str, unit: Any, counts_per_rev: int | None
) -> NDArray[Any]:
    """Convert a column to the unit of the set: counts, degrees, arcseconds, seconds, °C."""
    kind, values = QUANTITIES[quantity], frame.columns[column]
    if not isinstance(unit, str):
        unit, values = _of_astropy(frame, quantity, column, unit)
    array = _numbers(frame, column, values)
    if kind == "temperature":
        if unit == "K":
            return array - KELVIN_AT_0
        return array if unit == "degC" else (array - FAHRENHEIT_AT_0) / UNITS[kind]["degF"]
    if kind == "time":
        return array if unit == "s" else array / UNITS[kind][unit]
    wanted = SET_COLUMNS[frame.name][quantity].rpartition("_")[2]
    if unit == wanted:
        return _whole(frame, column, array) if wanted == "counts" else array
    if "counts" in (unit, wanted) and counts_per_rev is None:
        raise _fault(
            frame,
            column,
            f"is in {unit} and the set needs {wanted}: state how many counts are one turn, "
            "counts_per_rev=16777216",
        )
    turns = array / (float(counts_per_rev or 1) if unit == "counts" else UNITS["angle"][unit])
    if wanted == "counts":
        return np.round(turns * float(counts_per_rev or 1)).astype(np.int64)
    return np.asarray(turns * UNITS["angle"][wanted])


def _of_astropy(frame: Frame, quantity: str, column: str, unit: Any) -> tuple[str, Any]:
    """Return the workbench's name of an astropy unit, and the values of the column in that unit."""
    kind, values = QUANTITIES[quantity], frame.columns[column]
    text = str(unit)
    named = unit_named(kind, _OTHER_SPELLINGS.get(text, text))
    plain = getattr(values, "value", values)
    if named is not None:
        return named, plain
    ours = {"angle": "deg", "time": "s", "temperature": "K"}[kind]
    try:
        factor = float(unit.to(ours))
    except (TypeError, ValueError) as error:
        raise _fault(
            frame, column, f"expected a unit of {kind} ({_units(kind)}), found {text!r}"
        ) from error
    return ours, np.asarray(plain, dtype=np.float64) * factor


def _masked(values: Any) -> NDArray[np.bool_]:
    """Return the mask of a masked array (numpy, astropy), (n,); a single False without a mask."""
    mask = getattr(values, "mask", None)
    if mask is None or callable(mask):
        return np.zeros(1, dtype=np.bool_)
    return np.atleast_1d(np.asarray(mask, dtype=np.bool_))


def _refuse_masked(frame: Frame, column: str, values: Any) -> None:
    """Raise MeasurementError with the first row whose value is masked."""
    rows = np.flatnonzero(_masked(values))
    if rows.size:
        raise _fault(
            frame,
            column,
            f"row {rows[0]}: the value is masked, as in {rows.size} rows in all; leave such rows "
            "out first",
            fault="not_a_number",
        )


def _dates(frame: Frame, column: str, values: Any) -> tuple[NDArray[np.int64], Dates] | None:
    """Return nanoseconds since 1970, or the nanoseconds of a duration; None for other values.

    Dates without a time zone are UTC. Raises MeasurementError with the row of the first date that
    is missing.
    """
    array = values.to_numpy() if hasattr(values, "to_numpy") else np.asarray(values)
    if array.dtype.kind == "O" and array.size and any(hasattr(one, "timestamp") for one in array):
        _refuse_missing(frame, column, [item is None or item != item for item in array])
        wrong = [place for place, one in enumerate(array) if not hasattr(one, "timestamp")]
        zoned = [getattr(item, "tzinfo", None) is not None for item in array]
        wrong += [place for place, one in enumerate(zoned) if one != zoned[0]]
        if wrong:
            raise _fault(
                frame,
                column,
                f"row {min(wrong)}: expected dates that all have a time zone or all have none",
            )
        kind: Dates = "zone" if zoned[0] else "utc"
        return np.array([_nanoseconds(item) for item in array], dtype=np.int64), kind
    if array.dtype.kind in "Mm":
        _refuse_missing(frame, column, np.isnat(array))
    if array.dtype.kind == "M":
        return array.astype("datetime64[ns]").astype(np.int64), "utc"
    if array.dtype.kind == "m":
        return array.astype("timedelta64[ns]").astype(np.int64), "duration"
    return None


def _nanoseconds(moment: Any) -> int:
    """Return the nanoseconds since 1970 of a datetime or of a Timestamp of pandas, exactly."""
    zone = None if moment.tzinfo is None else UTC
    since = moment - datetime(1970, 1, 1, tzinfo=zone)
    whole = (since.days * 86400 + since.seconds) * 1_000_000 + since.microseconds
    return int(whole * 1000 + getattr(since, "nanoseconds", 0))


def _refuse_missing(frame: Frame, column: str, missing: Any) -> None:
    rows = np.flatnonzero(missing)
    if rows.size:
        raise _fault(
            frame,
            column,
            f"row {rows[0]}: expected a time, found NaT; leave such rows out first, for instance "
            "with frame.dropna()",
            fault="not_a_number",
        )


def _numbers(frame: Frame, column: str, values: Any) -> NDArray[Any]:
    """Return the values (n,) as numbers.

    Raises MeasurementError with the row of the first value that is not a finite number.
    """
    array = np.asarray(values)
    if array.ndim != 1:
        raise _fault(frame, column, f"expected a row of numbers, found an array {array.shape}")
    if array.dtype.kind in "iub":
        large = np.flatnonzero(array > np.iinfo(np.int64).max)
        if large.size:
            raise _fault(
                frame,
                column,
                f"row {large[0]}: expected a number below 2⁶³, found {array[large[0]]}",
            )
        return array.astype(np.int64)
    if array.dtype.kind == "c":
        raise _fault(frame, column, f"row 0: expected a real number, found {array[0]}")
    try:
        numbers = array.astype(np.float64)
    except (TypeError, ValueError):
        place = next(i for i, item in enumerate(array.tolist()) if not _is_number(item))
        raise _fault(
            frame, column, f"row {place}: expected a number, found {array[place]!r}"
        ) from None
    missing = np.flatnonzero(~np.isfinite(numbers))
    if missing.size:
        raise _fault(
            frame,
            column,
            f"row {missing[0]}: expected a finite number, found {numbers[missing[0]]}; leave such "
            "rows out first, for instance with frame.dropna()",
            fault="not_a_number",
        )
    return numbers


def _whole(frame: Frame, column: str, array: NDArray[Any]) -> NDArray[np.int64]:
    """Return the numbers as integers.

    Raises MeasurementError with the row of the first number that is not whole.
    """
    found = array.astype(np.int64)
    wrong = np.flatnonzero(found != array)
    if wrong.size:
        raise _fault(
            frame, column, f"row {wrong[0]}: expected a whole number, found {array[wrong[0]]:g}"
        )
    return found


def _is_number(item: Any) -> bool:
    try:
        float(item)
    except (TypeError, ValueError):
        return False
    return True


def _fault(
    frame: Frame, column: str, message: str, *, missing: bool = False, fault: str = ""
) -> MeasurementError:
    kind: Any = fault or ("missing" if missing else "value")
    return MeasurementError(kind, Path(frame.name), message, column=column)
