"""Finds regular causes in a reference run with closely spaced rows. A forward search finds lines
(sinusoidal errors), ordered by the error that they explain.

Single omitted rows cannot test a line far above the scatter of the rows, because the neighbours of
an omitted row already predict it. This search predicts whole blocks of the record; every line of
its result has passed this test.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.diagnose.detections import (
    SAME_LINE,
    Band,
    Detections,
    FastLineOfRows,
    RegularCause,
)
from arctrue.workbench.diagnose.events_of_stations import events_of_stations, jump_of
from arctrue.workbench.diagnose.jumps import Jump
from arctrue.workbench.diagnose.undetermined import undetermined
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.forward.cycles import cycle_change, run_change
from arctrue.workbench.inference.forward.even_drift import EvenDrift, even_drift
from arctrue.workbench.inference.forward.events import columns_of_steps
from arctrue.workbench.inference.forward.folded import is_alias
from arctrue.workbench.inference.forward.mountings import mounting_change
from arctrue.workbench.inference.forward.noise_of_record import whitened_left
from arctrue.workbench.inference.forward.of_solution import records_of, reversal_with_steps
from arctrue.workbench.inference.forward.order_at_speeds import is_an_order
from arctrue.workbench.inference.forward.oscillation import (
    Oscillation,
    in_each_run,
    oscillation_in_reference,
    oscillation_of,
)
from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.inference.forward.search import Line, LineSearch, search_record
from arctrue.workbench.inference.forward.slow import SlowChange, slow_change
from arctrue.workbench.inference.forward.tests_of_a_line import nearest
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.inference.visits_of_places import visits_of
from arctrue.workbench.noise.level import noise_level
from arctrue.workbench.observations.display_step import display_step

Float = NDArray[np.float64]


def detections_of(solution: Solution, effects: Mapping[str, type[Effect]]) -> Detections:
    """Search a reference for lines, steps, an oscillation, a slow change, a reversal error, and an
    error that repeats at the same places.

    If the rows do not determine the model, there are no detections, because lines would only cancel
    the model's orders. The error of single places is subtracted before the other searches, because
    a defect that every turn repeats looks like an oscillation or a line. A slow change counts only
    if it remains after the error that repeats at equal places is subtracted.
    """
    if undetermined(solution) is not None:
        return Detections()
    visits = visits_of(solution)
    places = None if visits is None else visits.repeated()
    if visits is None or places is None:
        return _of_rows(solution, effects)
    observations = solution.observations
    rows = observations.reference
    assert rows is not None

    def of_rows_without(error_arcsec: Float) -> Detections:
        left = replace(rows, error_arcsec=rows.error_arcsec - error_arcsec)
        without = replace(observations, reference=left)
        return _of_rows(fit(solution.terms, without), effects)

    if observations.stored_reference is not None:
        found = replace(_of_rows(solution, effects), places=places)
        return replace(found, slow=None) if places.is_most else found
    if places.is_located:
        return replace(of_rows_without(visits.of_single_places), places=places)
    found = replace(_of_rows(solution, effects), places=places)
    if found.slow is None or places.is_most:
        return replace(found, slow=None)
    return replace(found, slow=of_rows_without(visits.of_all_places).slow)


def _of_rows(solution: Solution, effects: Mapping[str, type[Effect]]) -> Detections:
    """Return the detections apart from the error that repeats at the same places."""
    expected = _expected(solution, effects)
    unknown = next((kind() for kind in effects.values() if kind.search_kind == "line"), None)
    if unknown is None:
        return Detections()
    declared = None
    if expected is not None:
        declared = expected.declared_order(solution.observations)
    causes: list[RegularCause] = []
    whiteness: list[float] = []
    rows = solution.observations.reference
    timed = rows is not None and rows.time_s is not None
    bands: list[Band] = []
    steps: list[Jump] = []
    oscillation: Oscillation | None = None
    slow: SlowChange | None = None
    ratio = 0.0
    quantum = 0.0 if rows is None else display_step(rows.error_arcsec)
    fast: list[FastLineOfRows] = []
    drift: EvenDrift | None = None
    of_orders: Record | None = None
    for record in records_of(solution, declared):
        found = search_record(record, quantum)
        whiteness.append(found.whiteness_p)
        bands.append(Band(record.in_time, record.highest))
        level = noise_level(whitened_left(record.rows(_columns_of(found)), found.noise.noise))
        ratio = ratio if level is None else max(ratio, level.ratio)
        if timed and oscillation is None:
            oscillation = oscillation_of(found, "reference")
            if oscillation is not None and is_alias(solution, oscillation, record.step):
                oscillation = oscillation_in_reference(solution)
        if timed and not bands[1:]:
            slow = slow_change(record, _columns_of(found))
        if timed and found.lines and drift is None:
            drift = even_drift(record, _columns_of(found), found.noise.noise)
        if not steps:
            steps = [jump_of(step, record, timed=timed) for step in found.steps]
        turns_s = _common_speed(record) if timed else None
        fast += _fast(record, turns_s, fast)
        causes += [
            item
            for item in _causes(found, expected, unknown, turns_s)
            if not any(
                _is_same(item, other, record) or _is_at_a_speed(item, other, of_orders)
                for other in causes
            )
            and not (
                item.in_time
                and of_orders is not None
                and is_an_order(found, item.lines[0].rate, of_orders)
            )
        ]
        of_orders = of_orders if record.in_time else record
    if not bands:
        steps, slow = events_of_stations(solution, quantum, timed=timed)
    cycles = None
    if not bands:
        cycles = mounting_change(solution) or cycle_change(solution) or run_change(solution)
    if cycles is not None:
        # A few offsets are neither a slow curve nor a single event.
        steps, slow = [], None
    oscillation = in_each_run(solution, oscillation)
    times = [step.time_s for step in steps if step.time_s is not None]
    reversal = reversal_with_steps(solution, times)
    causes.sort(key=lambda item: -item.taken_arcsec)
    # The records over time and over the angle have the same rows: if the residuals of one are
    # white, the rows are white.
    return Detections(
        tuple(causes),
        tuple(steps),
        max(whiteness, default=None),
        tuple(bands),
        oscillation,
        slow,
        reversal,
        ratio or None,
        cycles,
        fast=tuple(sorted(fast, key=lambda line: -line.amplitude_arcsec)),
        drift=drift if slow is None else None,
    )


SAME_SPEED = 0.01
"""Largest relative difference between the speeds of two stretches at which one period is stated for
an order; a drive without a servo holds its speed to about 1 %."""


def _common_speed(record: Record) -> float | None:
    """Return the mean speed in turns per second; None if the stretches of a record over the angle
    differ in speed, so that an order has no period."""
    if record.in_time:
        return record.turns_on_the_clock
    speeds = [speed for _, speed in _speeds(record)]
    if not speeds or max(speeds) - min(speeds) > SAME_SPEED * max(speeds):
        return None
    return record.turns_on_the_clock


def _speeds(record: Record) -> Iterator[tuple[float, float]]:
    """Yield the length of each stretch in seconds and its speed in turns per second."""
    for number in np.unique(record.stretch):
        own = record.stretch == number
        length = float(np.ptp(record.measured[own]))
        if length > 0.0:
            yield length, float(np.ptp(record.place[own])) / length


def _fast(
    record: Record, turns_s: float | None, known: Sequence[FastLineOfRows]
) -> list[FastLineOfRows]:
    """Return the fast lines of a record without those that a record over the angle also shows."""
    found = [
        FastLineOfRows(
            line.rate, line.amplitude_arcsec, record.in_time, None if record.in_time else turns_s
        )
        for line in record.fast
    ]
    if not record.in_time:
        return found
    rates = [1.0 / line.period_s for line in known if line.period_s is not None]
    return [line for line in found if nearest(rates, line.rate) * record.span >= SAME_LINE]


def _columns_of(found: LineSearch) -> Float:
    """Return the columns of the lines and steps that were found, shape (rows, k)."""
    record = found.record
    lines = record.columns(np.array([line.rate for line in found.lines]))
    return np.hstack([lines, columns_of_steps(record, found.steps)])


def _expected(solution: Solution, effects: Mapping[str, type[Effect]]) -> Effect | None:
    """Return an effect that the model lacks and for which the set declares an order; None if there
    is no such effect."""
    present = {term.effect.name for term in solution.terms}
    for name, kind in effects.items():
        if name not in present and kind.multiples_setting is not None:
            effect = kind()
            if effect.declared_order(solution.observations) is not None:
                return effect
    return None


def _causes(
    found: LineSearch, expected: Effect | None, unknown: Effect, timed_turns_s: float | None
) -> list[RegularCause]:
    record = found.record
    turns_s = None if record.in_time else timed_turns_s
    causes = [
        RegularCause(unknown, _place(line, record), (line,), record.in_time, turns_s)
        for line in found.lines
        if line.multiple is None
    ]
    of_declared = tuple(line for line in found.lines if line.multiple is not None)
    if of_declared and expected is not None and expected.multiples_setting is not None:
        multiples = sorted({line.multiple for line in of_declared if line.multiple is not None})
        form = type(expected)(**{expected.multiples_setting: multiples})
        causes.append(RegularCause(form, {}, of_declared, record.in_time, turns_s))
    return causes


def _is_same(item: RegularCause, other: RegularCause, record: Record) -> bool:
    """Tell whether a line over time is the same line as a line that was found over the angle."""
    if not item.in_time or other.in_time or other.turns_s is None:
        return False
    rates = [line.rate * other.turns_s for line in other.lines]
    return nearest(rates, item.lines[0].rate) * record.span < SAME_LINE


def _is_at_a_speed(item: RegularCause, other: RegularCause, record: Record | None) -> bool:
    """Tell whether a line over time has the frequency of an order at the speed of a stretch.

    ``record`` is the record over the angle; over time, an order is one line for each speed.
    """
    if record is None or not item.in_time or other.in_time:
        return False
    for length, speed in _speeds(record):
        rates = [line.rate * speed for line in other.lines]
        if nearest(rates, item.lines[0].rate) * length < SAME_LINE:
            return True
    return False


def _place(line: Line, record: Record) -> dict[str, float]:
    return {
        "order": 0.0 if record.in_time else line.rate,
        "frequency": line.rate if record.in_time else 0.0,
        "in_time": float(record.in_time),
        "in_capture": 0.0,
    }
