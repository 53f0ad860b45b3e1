"""Joins several measurement sets of one table into one set with all their runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, Literal, TypeVar

import numpy as np

from arctrue.measurement.measurement_set import Capture, MeasurementSet, Reference, Table

Times = Literal["", "keep", "after"]
Rows = TypeVar("Rows", Capture, Reference)

SAME_SEPARATION_DEG = 0.25
"""Largest difference between the head separations of two sets of one table; each device states the
separation that it measured, so the values may differ."""


class JoinError(ValueError):
    """Is raised if the sets cannot be joined into one measurement."""


class OverlapError(JoinError):
    """Is raised if the times of a later set begin before the earlier sets end."""


def joined(
    sets: Sequence[MeasurementSet], *, times: Times = "", common_columns: bool = False
) -> tuple[MeasurementSet, list[str]]:
    """Join the rows of several sets of one table, one set after the other.

    Run and cycle numbers of later sets are increased so that no number occurs twice. The times of a
    reference are converted to the clock of its capture.

    Parameters
    ----------
    sets : sequence of MeasurementSet
        Sets of the same table.
    times : {"", "after", "keep"}, optional
        Treatment of a set whose clock restarts: ``after`` shifts its times past the end of the
        previous set, ``keep`` keeps its times; by default such a set is refused.
    common_columns : bool, optional
        Leave out columns that not all sets have.

    Returns
    -------
    joined : MeasurementSet
        All rows.
    notes : list of str
        Decisions, one sentence each.

    Raises
    ------
    JoinError
        If the sets are of different tables, state different values for a key, contain the same
        rows, or have different columns without ``common_columns``.
    OverlapError
        If the times of a set begin before the earlier sets end, and ``times`` is "".
    """
    names = [str(item.folder or item.title or number) for number, item in enumerate(sets, start=1)]
    notes: list[str] = []
    table = _same_table(sets, names)
    _no_twins(sets, names)
    captures: list[tuple[str, Capture]] = []
    references: list[tuple[str, Reference]] = []
    next_run = next_cycle = 0
    end_s: float | None = None
    for name, item in zip(names, sets, strict=True):
        item = _one_clock(item)
        shift_s, end_s = _time_shift(name, item, end_s, times, notes)
        runs = _numbers(item, "run")
        move = next_run - min(runs) if runs and min(runs) < next_run else 0
        next_run = max([next_run, *(number + move + 1 for number in runs)])
        cycles = _numbers(item, "cycle")
        turn = next_cycle - min(cycles) if cycles and min(cycles) < next_cycle else 0
        next_cycle = max([next_cycle, *(number + turn + 1 for number in cycles)])
        if move:
            notes.append(f"{name}: its runs are numbered from {min(runs) + move}")
        if item.capture is not None:
            captures.append((name, _moved(item.capture, move, turn, shift_s)))
        if item.reference is not None:
            references.append((name, _moved(item.reference, move, turn, shift_s)))
    title = next((item.title for item in sets if item.title), "")
    result = replace(
        sets[0],
        table=table,
        capture=_stacked(captures, common_columns, notes) if captures else None,
        reference=_stacked(_rows_with_uncertainty(references), common_columns, notes)
        if references
        else None,
        title=title,
        date=min((item.date for item in sets if item.date is not None), default=None),
        other={key: value for item in reversed(sets) for key, value in item.other.items()},
        warnings=(),
        folder=None,
    )
    return result, notes


def _same_table(sets: Sequence[MeasurementSet], names: Sequence[str]) -> Table:
    found: dict[str, tuple[str, Any]] = {}
    for name, item in zip(names, sets, strict=True):
        for key in fields(Table):
            value = getattr(item.table, key.name)
            if value is None:
                continue
            first, before = found.setdefault(key.name, (name, value))
            slack = SAME_SEPARATION_DEG if key.name.startswith("head_") else 0.0
            if np.size(value) != np.size(before) or np.any(
                np.abs(np.subtract(value, before)) > slack
            ):
                raise JoinError(
                    f"{name} is of another table than {first}: {key.name} is {value}, not {before}"
                )
    values = {key: value for key, (_, value) in found.items()}
    if "head_places_deg" in values:
        # The head separation is the second of the head places, so both are taken from the same set.
        del values["head_separation_deg"]
    return Table(**values)


def _no_twins(sets: Sequence[MeasurementSet], names: Sequence[str]) -> None:
    for place, item in enumerate(sets):
        for before in range(place):
            for one, other, column in (
                (sets[before].capture, item.capture, "head2_counts"),
                (sets[before].reference, item.reference, "error_arcsec"),
            ):
                if one is None or other is None:
                    continue
                if np.array_equal(getattr(one, column), getattr(other, column)):
                    raise JoinError(f"{names[place]} holds the same rows as {names[before]}")


def _one_clock(item: MeasurementSet) -> MeasurementSet:
    """Return the set with the times of its reference converted to the clock of the capture."""
    reference = item.reference
    if reference is None or not reference.clock_offset_s or reference.time_s is None:
        return item
    moved = reference.time_s + reference.clock_offset_s
    return replace(item, reference=replace(reference, time_s=moved, clock_offset_s=None))


def _times(item: MeasurementSet) -> list[Any]:
    parts = (item.capture, item.reference)
    return [p.time_s for p in parts if p is not None and p.time_s is not None and p.time_s.size]


def _time_shift(
    name: str, item: MeasurementSet, end_s: float | None, times: Times, notes: list[str]
) -> tuple[float, float | None]:
    """Return the offset that is added to the times of a set, and the time at which the set then
    ends."""
    found = _times(item)
    if not found:
        return 0.0, end_s
    start, end = min(float(t.min()) for t in found), max(float(t.max()) for t in found)
    if end_s is None or start > end_s or times == "keep":
        return 0.0, max(end, end_s) if end_s is not None else end
    if times != "after":
        raise OverlapError(
            f"{name} begins at {start:g} s, but the previous set ends at {end_s:g} s: the clock "
            "began anew. Give --times after (the times follow those of the previous set) or "
            "--times keep (both sets have the same clock)"
        )
    step = min((float(np.median(np.diff(t))) for t in found if t.size > 1), default=1.0)
    shift = end_s + max(step, 1e-6) - start
    notes.append(
        f"{name}: its clock began anew; {shift:.6g} s are added, because the pause is not known"
    )
    return shift, end + shift


def _numbers(item: MeasurementSet, column: str) -> list[int]:
    found: set[int] = set()
    for part in (item.capture, item.reference):
        values = getattr(part, column, None)
        if values is not None:
            found |= set(np.unique(values).tolist())
        elif isinstance(part, Reference):
            found.add(0)
    return sorted(found)


def _moved(rows: Rows, runs: int, cycles: int, shift_s: float) -> Rows:
    changed: dict[str, Any] = {}
    if rows.time_s is not None:
        changed["time_s"] = rows.time_s + shift_s
    if isinstance(rows, Reference):
        size = rows.error_arcsec.size
        # A reference run without the column ``cycle`` counts as one cycle; without ``run``, as one
        # run.
        before = np.zeros(size, dtype=np.int64) if rows.cycle is None else rows.cycle
        changed["cycle"] = before + cycles
    run = rows.run
    if run is None and isinstance(rows, Reference):
        run = np.zeros(rows.error_arcsec.size, dtype=np.int64)
    assert run is not None
    changed["run"] = run + runs
    return replace(rows, **changed)


def _rows_with_uncertainty(
    references: Sequence[tuple[str, Reference]],
) -> list[tuple[str, Reference]]:
    """Return the reference runs of the sets; if all state an uncertainty and the uncertainties
    differ, store them as columns."""
    stated = {rows.standard_uncertainty_arcsec for _, rows in references}
    if len(stated) < 2 or None in stated:
        return list(references)
    return [
        (
            name,
            replace(
                rows,
                standard_uncertainty_arcsec=None,
                u_arcsec=np.full(rows.error_arcsec.size, rows.standard_uncertainty_arcsec)
                if rows.u_arcsec is None
                else rows.u_arcsec,
            ),
        )
        for name, rows in references
    ]


def _stacked(parts: Sequence[tuple[str, Rows]], common_columns: bool, notes: list[str]) -> Rows:
    """Concatenate the rows of all sets."""
    first = parts[0][1]
    values: dict[str, Any] = {}
    for item in fields(first):
        column = item.name
        found = [getattr(rows, column) for _, rows in parts]
        if column == "conditions":
            names = dict.fromkeys(key for one in found for key in one)
            values[column] = {
                key: np.concatenate([one[key] for one in found])
                for key in names
                if _in_all(key, [key in one for one in found], parts, common_columns, notes)
            }
        elif column in ("mask", "trusted"):
            any_there = any(one is not None for one in found)
            masks = [_flags(one, rows) for one, (_, rows) in zip(found, parts, strict=True)]
            values[column] = np.concatenate(masks) if any_there else None
        elif any(isinstance(one, np.ndarray) for one in found):
            there = [one is not None for one in found]
            kept = _in_all(column, there, parts, common_columns, notes)
            values[column] = np.concatenate(found) if kept else None
        else:
            values[column] = _one_value(column, found, parts)
    return type(first)(**values)


def _flags(given: Any, rows: Capture | Reference) -> Any:
    size = (rows.head1_counts if isinstance(rows, Capture) else rows.error_arcsec).size
    return np.zeros(size, dtype=bool) if given is None else given


def _in_all(
    column: str,
    there: Sequence[bool],
    parts: Sequence[tuple[str, Any]],
    common_columns: bool,
    notes: list[str],
) -> bool:
    if all(there):
        return True
    if not any(there):
        return False
    lacking = ", ".join(name for (name, _), one in zip(parts, there, strict=True) if not one)
    if not common_columns:
        raise JoinError(
            f"{lacking} has no column {column}, the others have; arctrue join --common-columns "
            "leaves it out"
        )
    notes.append(f"column {column} is left out: {lacking} has none")
    return False


def _one_value(column: str, found: Sequence[Any], parts: Sequence[tuple[str, Any]]) -> Any:
    stated = list(dict.fromkeys(one for one in found if one is not None))
    if len(stated) < 2:
        return stated[0] if stated else None
    if column == "instrument":
        return "; ".join(stated)
    last = next(name for (name, _), one in zip(parts, found, strict=True) if one == stated[1])
    raise JoinError(f"{last}: {column} is {stated[1]}, not {stated[0]} as in {parts[0][0]}")
