"""Averages the residuals of a fitted model in the reference to records, in which the forward search
looks for lines and steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.design_matrix import block_columns, row_blocks
from arctrue.workbench.inference.forward.record import Record, averaged_fast_lines, record_of
from arctrue.workbench.inference.forward.reversal import Reversal, reversal_of
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.law import reference_clock, stretch_starts
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.one_speed import coordinate, speed_turns_s
from arctrue.workbench.observations.rows import ReferenceRows

Float = NDArray[np.float64]

LEAST_ROWS = 200
"""Smallest number of rows of a record. A record with fewer rows has at most 50 independent rates,
some of which the model contains; the other searches of the diagnosis find its lines.
"""
LEAST_STRETCH_ROWS = 50
"""Fewest rows of a stretch: twelve periods of the line with the highest rate of the search."""
LEAST_EVENT_ROWS, LEAST_STRETCH_STATIONS = 30, 12
"""Fewest rows of a record, and of each of its stretches, for the search of events: with fewer rows,
a step does not differ from a straight line through all rows."""
LEAST_FREE = 0.5
"""Smallest ratio of degrees of freedom (rows minus base columns) to rows. With a smaller ratio, 1
of 10 sets of white noise shows a step (``python -m scripts.calibrate_line_search --short``, 72
stations once and 40 coefficients)."""
SAME_STATION_RAD = 1e-6
"""Largest angle within one station: 0.2″, more than the rounding of a file and less than the
repeatability of a servo."""
FROM_ONE_SIDE = 0.5
"""Smallest ratio of the number of different angles to the number of rows: repeated visits of a few
stations show scatter, but no line."""


def records_of(solution: Solution, declared: float | None) -> list[Record]:
    """Return records over the angle and over time; only the first if both show the same.

    Both show the same at a constant speed. A record of one turn over the angle is also returned
    alone.

    The list is empty for repeated stations and for few rows. ``declared``: order whose multiples
    are expected.
    """
    rows = solution.observations.every_reference_row
    kept_rows = _kept_rows(solution)
    if rows is None or kept_rows is None:
        return []
    clock, residual, columns, stretch, kept = kept_rows
    found = []
    places = [_moving(coordinate(rows, in_time=in_time), kept) for in_time in (False, True)]
    moving = [place for place in places if place is not None]
    fast = averaged_fast_lines(moving, stretch, residual)
    for in_time, place in zip((False, True), places, strict=True):
        if place is None:
            continue
        record = record_of(
            clock,
            place,
            stretch,
            residual,
            columns,
            in_time=in_time,
            declared=None if in_time else declared,
            fast=fast,
        )
        if record.span * record.highest < 1.0:
            continue
        found.append(record)
        one_speed = not in_time and speed_turns_s(rows, record.highest) is not None
        if one_speed or record.whole_orders_only:
            # In one turn, a dependence on the direction would look, over time, like lines next to
            # the orders of that turn.
            break
    return found


def _kept_rows(
    solution: Solution,
) -> tuple[Float, Float, Float, NDArray[np.int64], NDArray[np.bool_]] | None:
    """Return clock, residual, columns and number of the stretch of the rows of a log, and which
    rows these are; None for repeated stations and for few rows."""
    rows = solution.observations.every_reference_row
    if rows is None or "reference" in solution.unknown_noise or not _is_dense(rows):
        return None
    clock = reference_clock(rows)
    stretch = _stretches(rows, clock)
    kept = np.bincount(stretch)[stretch] >= LEAST_STRETCH_ROWS
    if np.count_nonzero(kept) < LEAST_ROWS:
        return None
    stretch = np.unique(stretch[kept], return_inverse=True)[1]
    columns, residual = _left(solution, rows)
    return clock[kept], residual[kept], columns[kept], stretch, kept


def stretches_of(
    solution: Solution,
) -> tuple[Float, Float, Float, NDArray[np.int64]] | None:
    """Return times, residuals, columns of the model and number of the stretch of each row of a log
    with times; None if the reference is not such a log."""
    rows, found = solution.observations.every_reference_row, _kept_rows(solution)
    if rows is None or rows.time_s is None or found is None:
        return None
    clock, residual, columns, stretch, _ = found
    steps = np.diff(clock)[np.diff(stretch) == 0]
    return (clock, residual, columns, stretch) if np.all(steps > 0.0) else None


def _moving(place: Float | None, kept: NDArray[np.bool_]) -> Float | None:
    """Return the coordinate of the kept rows; None if it is not known or does not change."""
    moves = place is not None and float(np.ptp(place)) > 0.0
    return place[kept] if place is not None and moves else None


def longest_stretch(solution: Solution) -> tuple[Float, Float, int] | None:
    """Return times and residuals of the longest stretch of successive rows of the reference, and
    the number of all its rows; None if there is no such stretch with times.

    The stretch may be a log, or one run over many stations.
    """
    rows = solution.observations.every_reference_row
    if rows is None or rows.time_s is None or "reference" in solution.unknown_noise:
        return None
    clock = reference_clock(rows)
    stretch = _stretches(rows, clock)
    kept = np.flatnonzero(stretch == int(np.argmax(np.bincount(stretch))))
    if kept.size < LEAST_ROWS or not np.all(np.diff(clock[kept]) > 0.0):
        return None
    return clock[kept], _left(solution, rows)[1][kept], clock.size


def has_records(solution: Solution) -> bool:
    """Tell whether the reference is a log, which :func:`records_of` averages to records."""
    rows = solution.observations.every_reference_row
    return rows is not None and _is_dense(rows)


def _stretches(rows: ReferenceRows, clock: Float) -> NDArray[np.int64]:
    """Return the number of the stretch of each row."""
    first = np.zeros(clock.size, dtype=np.int64)
    first[stretch_starts(clock, rows.run)[1:]] = 1
    if rows.direction is not None:
        # A change at a reversal is not a step in time, so a stretch ends at each reversal.
        first[1:] |= np.diff(rows.direction) != 0.0
    return np.cumsum(first)


def records_of_events(solution: Solution) -> list[Record]:
    """Return records of every row over time, or by row number, for events; none for too few rows.

    The first record is one stretch, if time continues from run to run: a part that was displaced
    stays displaced in the next run. In the second record each run is a stretch of its own: a
    counter that lost counts is corrected by the index at the start of the next run. Both records
    fit an effect of the direction of approach too, so that a reversal is not taken for a step.
    """
    rows = solution.observations.every_reference_row
    if rows is None or "reference" in solution.unknown_noise:
        return []
    clock = reference_clock(rows)
    back = (np.diff(clock, prepend=clock[:1]) < 0.0).astype(np.int64)
    goes_on, of_runs = np.cumsum(back), np.zeros(clock.size, dtype=np.int64)
    of_runs[stretch_starts(clock, rows.run)[1:]] = 1
    columns, left = _left(solution, rows)
    if rows.direction is not None:
        columns = np.column_stack([columns, rows.direction])
    found: list[Record] = []
    turns = coordinate(rows, in_time=False)
    for stretch in (goes_on, np.cumsum(of_runs)):
        same = np.diff(stretch) == 0
        if clock.size < LEAST_EVENT_ROWS or np.min(np.bincount(stretch)) < LEAST_STRETCH_STATIONS:
            continue
        if (found and np.array_equal(stretch, goes_on)) or np.any((np.diff(clock) == 0.0) & same):
            # Rows with the same time have no order in time.
            continue
        fast = averaged_fast_lines([clock, *([] if turns is None else [turns])], stretch, left)
        record = record_of(clock, clock, stretch, left, columns, in_time=True, fast=fast)
        if record.clock.size - record.base.shape[1] > LEAST_FREE * record.clock.size:
            found.append(record)
    return found


def reversal_with_steps(solution: Solution, steps_s: Sequence[float]) -> Reversal | None:
    """Return the difference of the readings between directions of approach, fitted together with
    steps.

    ``steps_s``: times of the steps. The result is None for stations at faces, for few rows, for one
    direction only, and if the time does not increase through all rows.
    """
    rows = solution.observations.every_reference_row
    if rows is None or rows.direction is None or rows.time_s is None:
        return None
    if rows.run.size < LEAST_ROWS or rows.faces is not None:
        return None
    clock = reference_clock(rows)
    if "reference" in solution.unknown_noise or np.any(np.diff(clock) <= 0.0):
        return None
    columns, left = _left(solution, rows)
    one = np.zeros(clock.size, dtype=np.int64)
    turns = coordinate(rows, in_time=False)
    fast = averaged_fast_lines([clock, *([] if turns is None else [turns])], one, left)
    record = record_of(clock, clock, one, left, columns, in_time=True, fast=fast)
    # An averaged row with a reversal within it gets the direction of its middle row.
    nearest_row = np.searchsorted(0.5 * (clock[1:] + clock[:-1]), record.measured)
    direction = np.sign(rows.direction)
    steps = (record.measured[:, np.newaxis] >= np.asarray(steps_s)).astype(np.float64)
    return reversal_of(record, direction[nearest_row], steps)


def without_steps(observations: Observations, steps: Sequence[tuple[float, float]]) -> Observations:
    """Return the observations with steps subtracted from the reference; each step, a time in
    seconds and a size in arcseconds, lasts to the end of its stretch."""

    def corrected(rows: ReferenceRows) -> ReferenceRows:
        clock = reference_clock(rows)
        stretch = _stretches(rows, clock)
        error = rows.error_arcsec.copy()
        for time_s, size_arcsec in steps:
            after = clock >= time_s
            if after.any():
                after &= stretch == stretch[int(np.argmax(after))]
                error[after] -= size_arcsec
        return replace(rows, error_arcsec=error)

    rows, stored = observations.reference, observations.stored_reference
    return replace(
        observations,
        reference=None if rows is None else corrected(rows),
        stored_reference=None if stored is None else corrected(stored),
    )


def _is_dense(rows: ReferenceRows) -> bool:
    """Tell whether the rows are a log (a run with closely spaced rows), not stations that are
    visited again and again.

    A log in motion may contain the same angles in every turn, if the number of samples per turn is
    whole. The turns of a log follow each other, so that the same angle on two turns counts as two
    different angles.
    """
    if rows.run.size < LEAST_ROWS or rows.faces is not None:
        return False
    side = np.zeros(rows.run.size) if rows.direction is None else rows.direction
    moving = rows.speed_rad_s is not None and np.count_nonzero(rows.speed_rad_s) > rows.run.size / 2
    places = [np.mod(rows.target_rad, 2.0 * np.pi), *([rows.target_rad] if moving else [])]
    return any(_places_of_their_own(place, side) > FROM_ONE_SIDE for place in places)


def _places_of_their_own(place_rad: Float, side: Float) -> float:
    """Return the number of different pairs of angle and direction, divided by the number of
    rows."""
    station = np.round(place_rad / SAME_STATION_RAD).astype(np.int64)
    own = np.unique(np.stack([station, side.astype(np.int64)]), axis=1).shape[1]
    return float(own / station.size)


def _left(solution: Solution, rows: ReferenceRows) -> tuple[Float, Float]:
    """Return the columns of the model for every row, and the residuals of the model."""
    columns = np.empty((rows.run.size, sum(solution.widths)))
    for block in row_blocks(rows.run.size):
        columns[block] = block_columns(
            solution.terms, solution.widths, rows.part(block), solution.context
        )
    left = rows.measured_arcsec - columns @ solution.coefficients
    return columns, np.asarray(left - solution.reference_offset_arcsec)
