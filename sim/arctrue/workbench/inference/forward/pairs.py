"""Tests two or three lines next to each other together, because each of them alone looks like an
oscillation driven by noise: their sum beats, so that one sine loses its phase."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.changed_line import changed_line
from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.inference.forward.scan_of_rates import moved_in_turn, scan
from arctrue.workbench.inference.forward.tests_of_a_line import (
    LEAST_PERIODS,
    coherence,
    gain_over_an_oscillator,
    nearest,
    periods_in,
)
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import KernelFit, best_fit, fit_from, usual_starts

Float = NDArray[np.float64]

FARTHEST = 27.0
"""Largest distance of two neighbouring lines, in units of 1/span: the widest peak of the spectrum
that the search for oscillations tries (``oscillation.PEAK_ORDINATES``). Lines farther apart are
tested one by one."""
OVERSAMPLED = 4.0
"""Number of rates per 1/span among which a further line is searched."""
LEAST_BEATS = 2.0
"""Fewest beats of two lines in the record, also of a new line with an accepted one. With one beat,
a line whose phase or size changed once, or wanders, looks the same."""
SYMMETRIC = 0.5
"""Largest distance between an accepted line and the middle of two lines, in units of 1/span, at
which the two lines count as its side lines: half of the record's resolution."""
MOST_TOGETHER = 3
"""Largest number of lines that are tested together: a line with a side line on each side, as of a
worm whose load changes."""


@dataclass(frozen=True, eq=False)
class Group:
    """Lines that passed the tests of one line, each with the others in the model."""

    rates: tuple[float, ...]
    gains: tuple[float, ...]
    """Rise of the log likelihood by each line, with the others in the model."""
    oscillator_gains: tuple[float, ...]
    """Log likelihood that each line gains over an oscillator, with the others in the model."""
    fit: KernelFit
    """Noise with all these lines in the model."""


def group_of(
    record: Record,
    first: float,
    rates: Sequence[float],
    without: KernelFit,
    *,
    needed: float,
    predicted: float,
) -> Group | None:
    """Return the line near the rate ``first`` and one or two lines next to it, if all pass every
    test; otherwise None.

    ``without`` is the noise with the lines ``rates`` in the model. Each line must gain ``needed``
    over an oscillator that takes its place. All lines together must gain ``needed`` times their
    number over one oscillator that takes their place, and ``needed`` over one line that changes.
    The other blocks must predict more than the share ``predicted`` of each line.
    """
    own = [first]
    known = list(rates)
    while len(own) < MOST_TOGETHER:
        further = _further(record, known, own)
        if further is None:
            return None
        rows = record.rows(record.columns(np.array([*known, *own, further])))
        fit = best_fit(rows, [without.noise, *usual_starts(rows)])
        every = moved_in_turn(record, [*known, *own, further], fit.noise)
        known, own = every[: len(known)], every[len(known) :]
        if not _are_apart(record, known, own):
            return None
        fit = fit_from(record.rows(record.columns(np.array(every))), fit.noise)
        found = _tested(record, known, own, without, fit, needed, predicted)
        if found is not None:
            return found
        if fit.score - without.score <= len(own) * needed:
            return None
    return None


def _are_apart(record: Record, known: Sequence[float], own: Sequence[float]) -> bool:
    distances = [(high - low) * record.span for low, high in pairwise(sorted(own))]
    beats = min(nearest(known, rate) for rate in own) * record.span
    if min(*distances, beats) < LEAST_BEATS or max(distances) > FARTHEST:
        return False
    # Two lines at equal distances from an accepted line change its phase or its size: a slow change
    # of an unknown form, unless it has as many periods as a line.
    middle, reach = (min(own) + max(own)) / 2.0, (max(own) - min(own)) / 2.0
    wanders = nearest(known, middle) * record.span < SYMMETRIC
    return not (wanders and reach * record.span < LEAST_PERIODS)


def _tested(
    record: Record,
    known: Sequence[float],
    own: Sequence[float],
    without: KernelFit,
    fit: KernelFit,
    needed: float,
    predicted: float,
) -> Group | None:
    before, lines = record.columns(np.array(known)), record.columns(np.array(own))
    middle = own[0] if len(own) == 2 else sorted(own)[1]
    all_needed = len(own) * needed
    if (
        gain_over_an_oscillator(record, lines, before, middle, without, fit, all_needed)
        <= all_needed
    ):
        return None
    gains, over = [], []
    for at, rate in enumerate(own):
        others = np.hstack([before, np.delete(lines, [2 * at, 2 * at + 1], axis=1)])
        line = record.line_columns(rate)
        seen = coherence(record, line, others, fit.noise, periods_in(record, rate))
        if seen.share <= predicted:
            return None
        rows = record.rows(others)
        alone = best_fit(rows, [without.noise, fit.noise, *usual_starts(rows)])
        over.append(gain_over_an_oscillator(record, line, others, rate, alone, fit, needed))
        if over[-1] <= needed:
            return None
        gains.append(fit.score - alone.score)
    if fit.score - _best_rival(record, known, own, fit) <= needed:
        return None
    return Group(tuple(own), tuple(gains), tuple(over), fit)


def _best_rival(
    record: Record, known: Sequence[float], own: Sequence[float], fit: KernelFit
) -> float:
    """Return the highest score of a model in which one line changes its phase and size: a line in
    place of the lines ``own``, or an accepted line next to them."""
    parts = 2 * len(own) - 1
    ends = (min(own), max(own))
    scores = [changed_line(record, record.columns(np.array(known)), ends, parts, fit).score]
    for rate in known:
        if nearest(own, rate) * record.span <= FARTHEST:
            others = record.columns(np.array([other for other in known if other != rate]))
            scores.append(changed_line(record, others, (rate, rate), parts, fit).score)
    return max(scores)


def _further(record: Record, known: Sequence[float], own: Sequence[float]) -> float | None:
    """Return the rate next to the lines ``own`` that removes most from white noise, with the lines
    ``known`` and ``own`` in the model."""
    others = record.columns(np.array([*known, *own]))
    square = float(np.mean(record.rows(others).left() ** 2 * record.readings.mean()))
    steps = np.arange(-FARTHEST * OVERSAMPLED, FARTHEST * OVERSAMPLED + 1.0)
    grid = own[0] + steps / (OVERSAMPLED * record.span)
    grid = grid[_distance(grid, own) * record.span >= 1.0]
    grid = grid[_distance(grid, known) * record.span >= LEAST_BEATS]
    grid = grid[(grid > 1.0 / record.longest) & (grid <= record.highest)]
    if grid.size == 0:
        return None
    return float(grid[np.argmax(scan(record, grid, others, KernelNoise(max(square, 1e-30))))])


def _distance(grid: Float, rates: Sequence[float]) -> Float:
    if not rates:
        return np.full(grid.size, np.inf)
    return np.asarray(np.min(np.abs(grid[:, np.newaxis] - np.asarray(rates)), axis=1))
