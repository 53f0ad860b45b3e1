"""Makes capture and reference from the rows of files, with run, direction and cycle of each row."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.importing.choices import Choices
from arctrue.importing.errors_and_signs import error_of_readings, one_zero, signed_error
from arctrue.importing.file_rows import FileRows
from arctrue.importing.motion import Pass, cycles, passes
from arctrue.importing.quantities import HEADS
from arctrue.importing.settings import Settings
from arctrue.measurement import Capture, Reference, Table
from arctrue.measurement.wraps import same_turn, unwrapped_counts

Integer = NDArray[np.int64]
Float = NDArray[np.float64]


def _labelled(
    rows: FileRows, angle: Float, choices: Choices, *, split: bool
) -> tuple[Integer, Integer | None, Integer]:
    """Find run, direction (None if the rows are not in order of angle) and cycle of each row.

    A run, direction or cycle that the file states in a column takes precedence over one derived
    from the motion. With ``split``, a reversal divides a stated run, too.
    """
    given = rows.whole.get("run")
    label = np.zeros(angle.size, dtype=np.int64) if given is None else given
    begins = np.diff(label, prepend=label[:1]) != 0
    if rows.time_s is not None:
        back = np.flatnonzero((np.diff(rows.time_s, prepend=rows.time_s[:1]) < 0.0) & ~begins)
        if back.size:
            choices.note(
                f"{rows.name}: time steps back {back.size} times, first at row "
                f"{rows.line(int(back[0]))}: a new run begins there"
            )
        begins[back] = True
    stretches = run_spans(np.cumsum(begins))
    run = np.zeros(angle.size, dtype=np.int64)
    direction = np.zeros(angle.size, dtype=np.int64)
    cycle = np.zeros(angle.size, dtype=np.int64)
    moved = True
    number = 0
    for start, end in stretches:
        found = passes(angle[start:end])
        moved = moved and bool(found)
        cycle[start:end] = cycles(angle[start:end], found)
        pieces = found or [Pass(0, end - start, 0)]
        for piece in pieces:
            here = slice(start + piece.start, start + piece.end)
            direction[here] = piece.direction
            run[here] = number
            number += int(split or given is None)
        number += int(not split and given is not None)
    if given is None and moved and number > 1:
        choices.note(f"{rows.name}: {number} runs, from the reversals of the motion")
    elif given is not None and split and number > len(stretches):
        choices.note(f"{rows.name}: runs with a reversal are divided: {number} runs")
    if not moved:
        choices.note(
            f"{rows.name}: the rows are not in order of angle: no directions or cycles are assigned"
        )
    own_direction = rows.whole.get("direction")
    if own_direction is not None:
        return run, own_direction, rows.whole.get("cycle", cycle)
    return run, direction if moved else None, rows.whole.get("cycle", cycle)


def capture_of(files: list[FileRows], table: Table, choices: Choices) -> Capture:
    """Return the capture of the files' heads, with the counts continued past each turn."""
    counts_per_rev, places_deg = table.counts_per_rev, table.places_deg
    assert counts_per_rev is not None
    assert places_deg is not None
    parts: dict[str, list[Any]] = {}
    first_run = 0
    for rows in files:
        assert rows.time_s is not None
        run, _, _ = _labelled(rows, rows.unwrapped("head1", choices), choices, split=True)
        columns: dict[str, Any] = {"run": run + first_run, "time_s": rows.time_s}
        first_run = int(columns["run"].max()) + 1
        wrapped = 0
        heads = [name for name in HEADS if name in rows.angles]
        for name in heads:
            counts = rows.counts(name, counts_per_rev)
            counts, wraps = unwrapped_counts(counts, run, rows.time_s, counts_per_rev)
            columns[f"{name}_counts"] = counts
            wrapped += wraps
            if wraps:
                choices.note(
                    f"{rows.name}: {name} restarts at {counts_per_rev} counts {wraps} times; "
                    "the counts are continued past each turn"
                )
        for name, place_deg in zip(heads[1:], places_deg[1:], strict=False):
            if wrapped:
                columns[f"{name}_counts"] = same_turn(
                    columns["head1_counts"],
                    columns[f"{name}_counts"],
                    run,
                    counts_per_rev,
                    place_deg,
                )
        columns |= rows.further()
        for name, values in columns.items():
            parts.setdefault(name, []).append(values)
    joined = _stacked(parts, len(files))
    conditions = {name[1:]: joined.pop(name) for name in list(joined) if name.startswith("=")}
    return Capture(**joined, conditions=conditions)


def reference_of(files: list[FileRows], settings: Settings, choices: Choices) -> Reference:
    """Return the reference of the files, in degrees and arcseconds."""
    parts: dict[str, list[Any]] = {}
    first_run = first_cycle = 0
    compared = {
        number: error_of_readings(rows, settings.sign, choices)
        for number, rows in enumerate(files)
        if "head1" in rows.angles
    }
    compared = one_zero(files, compared, settings.zero, choices)
    for number, rows in enumerate(files):
        columns: dict[str, Any] = {}
        if number in compared:
            pair = compared.pop(number)
            target, error = pair.target, pair.error
            del pair
        else:
            target, error = rows.angles["target"], signed_error(rows, settings.sign, choices)
        run, direction, cycle = _labelled(
            rows, rows.unwrapped("target", choices, target), choices, split=False
        )
        if number:
            run, cycle = run + first_run, cycle + first_cycle
        columns["run"], columns["cycle"] = run, cycle
        first_run, first_cycle = int(columns["run"].max()) + 1, int(columns["cycle"].max()) + 1
        if rows.time_s is not None:
            columns["time_s"] = rows.time_s
        if direction is not None:
            columns["direction"] = direction
        columns["target_deg"] = target * 360.0
        columns["error_arcsec"] = error * ARCSEC_PER_TURN
        del target, error
        if "head1" in rows.angles and settings.table.counts_per_rev is not None:
            columns["head1_counts"] = rows.counts("head1", settings.table.counts_per_rev)
        columns |= rows.further()
        for name, values in columns.items():
            parts.setdefault(name, []).append(values)
    joined = _stacked(parts, len(files))
    conditions = {name[1:]: joined.pop(name) for name in list(joined) if name.startswith("=")}
    instrument = settings.instrument or next((f.instrument for f in files if f.instrument), None)
    return Reference(
        **joined,
        instrument=instrument,
        faces=settings.table.faces,
        standard_uncertainty_arcsec=settings.standard_uncertainty_arcsec,
        conditions=conditions,
    )


def _stacked(parts: dict[str, list[Any]], files: int) -> dict[str, Any]:
    lacking = [name.lstrip("=") for name, values in parts.items() if len(values) != files]
    if lacking:
        raise ValueError(f"some files lack {', '.join(lacking)}: import those files separately")
    # The function concatenates one column at a time, and returns a single file without a copy,
    # because a file may have 10⁶ rows.
    found = {}
    for name in list(parts):
        values = parts.pop(name)
        found[name] = values[0] if files == 1 else np.concatenate(values)
    return found
