"""Tests two lines next to each other together, because each of them alone looks like an oscillation
driven by noise: the sum of both beats, so that one sine loses its phase."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.inference.forward.scan_of_rates import moved_in_turn, scan
from arctrue.workbench.inference.forward.tests_of_a_line import (
    coherence,
    gain_over_an_oscillator,
    periods_in,
)
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import KernelFit, best_fit, fit_from, usual_starts

Float = NDArray[np.float64]

FARTHEST = 27.0
"""Largest distance of the two lines, in units of 1/span: the widest peak of the spectrum that the
search for oscillations tries (``oscillation.PEAK_ORDINATES``). Lines farther apart are tested one
by one."""
OVERSAMPLED = 4.0
"""Number of rates per 1/span among which the second line is searched."""
LEAST_BEATS = 2.0
"""Fewest beats of the two lines in the record. With one beat, a line whose phase or size changed
once looks the same."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Two lines that passed the tests of one line, each with the other in the model."""

    rates: tuple[float, float]
    gains: tuple[float, float]
    """Rise of the log likelihood by each line, with the other in the model."""
    oscillator_gains: tuple[float, float]
    """Log likelihood that each line gains over an oscillator, with the other in the model."""
    fit: KernelFit
    """Noise with both lines in the model."""


def pair_of(
    record: Record,
    first: float,
    rates: Sequence[float],
    without: KernelFit,
    *,
    needed: float,
    predicted: float,
) -> Pair | None:
    """Return the line near the rate ``first`` and a second line next to it, if both pass every
    test; otherwise None.

    ``without`` is the noise with the lines ``rates`` in the model. Each line must gain ``needed``
    over an oscillator that takes its place, and both together twice as much over one oscillator
    that takes the place of both. The other blocks must predict more than the share ``predicted`` of
    each.
    """
    span = record.span
    second = _second(record, [*rates, first])
    if second is None:
        return None
    rows = record.rows(record.columns(np.array([*rates, first, second])))
    fit = best_fit(rows, [without.noise, *usual_starts(rows)])
    every = moved_in_turn(record, [*rates, first, second], fit.noise)
    one, other = every[-2:]
    if not LEAST_BEATS <= abs(one - other) * span <= FARTHEST:
        return None
    fit = fit_from(record.rows(record.columns(np.array(every))), fit.noise)
    before = record.columns(np.array(every[:-2]))
    both = record.columns(np.array([one, other]))
    together = gain_over_an_oscillator(record, both, before, one, without, fit, 2.0 * needed)
    if together <= 2.0 * needed:
        return None
    gains, over = [], []
    for own, neighbour in ((one, other), (other, one)):
        others = np.hstack([before, record.line_columns(neighbour)])
        line = record.line_columns(own)
        seen = coherence(record, line, others, fit.noise, periods_in(record, own))
        if seen.share <= predicted:
            return None
        rows = record.rows(others)
        alone = best_fit(rows, [without.noise, fit.noise, *usual_starts(rows)])
        over.append(gain_over_an_oscillator(record, line, others, own, alone, fit, needed))
        if over[-1] <= needed:
            return None
        gains.append(fit.score - alone.score)
    return Pair((one, other), (gains[0], gains[1]), (over[0], over[1]), fit)


def _second(record: Record, rates: Sequence[float]) -> float | None:
    """Return the rate next to the last of ``rates`` that removes most from white noise."""
    others = record.columns(np.array(rates))
    square = float(np.mean(record.rows(others).left() ** 2 * record.readings.mean()))
    steps = np.arange(-FARTHEST * OVERSAMPLED, FARTHEST * OVERSAMPLED + 1.0)
    grid = rates[-1] + steps / (OVERSAMPLED * record.span)
    near = np.min(np.abs(grid[:, np.newaxis] - np.asarray(rates)), axis=1) * record.span < 1.0
    grid = grid[~near & (grid > 1.0 / record.longest) & (grid <= record.highest)]
    if grid.size == 0:
        return None
    return float(grid[np.argmax(scan(record, grid, others, KernelNoise(max(square, 1e-30))))])
