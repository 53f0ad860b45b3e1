"""Tests whether the offset of a reference changes between its cycles.

A mirror or polygon that moves when the table reverses or waits shifts every reading of a cycle.
Slow noise changes as much within a cycle as between two cycles, so that the changes at the ends of
the cycles are compared with the changes within them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from arctrue.workbench.inference.solution import Solution

Float = NDArray[np.float64]

SIDE_ROWS = 4
"""Rows on each side of a change, whose means are compared: a cycle of 24 faces has three pairs of
them, and slow noise over four rows is alike within and between cycles."""
LEAST_ENDS, LEAST_INSIDE = 4, 8
"""Fewest changes between and within cycles: with four and eight, F must exceed 25 at CHANGES_P."""
CHANGES_P = 1e-4
"""Largest p at which the offset counts as changing; it equals the limit of a sure lack of fit."""


MOST_WITHIN = 0.1
"""Largest share of an effect's sum of squares within the cycles at which its sample is the
cycles."""


@dataclass(frozen=True)
class CycleChange:
    """An offset of the reference that changes from cycle to cycle."""

    rms_arcsec: float
    """Standard deviation of the cycles' means."""

    def words(self) -> str:
        """Return the finding in words."""
        return (
            f"the offset of the reference changes from cycle to cycle by {self.rms_arcsec:.2g}″ "
            "RMS: the mirror or its mounting moved between the cycles"
        )


def cycle_change(solution: Solution) -> CycleChange | None:
    """Return the change of the offset between the cycles; None if the cycles do not show one.

    The means of both directions are removed first, because a reversal error also changes between
    cycles.
    """
    rows, left = solution.observations.reference, solution.reference_residual_arcsec()
    if rows is None or left is None or rows.cycle is None or solution.unknown_noise:
        return None
    if rows.direction is not None:
        for side in np.unique(rows.direction):
            own = rows.direction == side
            left = np.where(own, left - left[own].mean(), left)
    run, cycle = np.diff(rows.run) != 0, np.diff(rows.cycle) != 0
    ends = np.flatnonzero(run | cycle) + 1
    cycles = np.split(left, ends)
    inside = [
        _change(piece[start : start + 2 * SIDE_ROWS])
        for piece in cycles
        for start in range(0, piece.size - 2 * SIDE_ROWS + 1, 2 * SIDE_ROWS)
    ]
    between = [
        _change(left[end - SIDE_ROWS : end + SIDE_ROWS])
        for number, end in enumerate(ends)
        if not run[end - 1] and min(cycles[number].size, cycles[number + 1].size) >= SIDE_ROWS
    ]
    if len(between) < LEAST_ENDS or len(inside) < LEAST_INSIDE:
        return None
    noise = max(float(np.mean(np.square(inside))), 1e-300)
    ratio = float(np.mean(np.square(between))) / noise
    if float(fdtrc(len(between), len(inside), ratio)) >= CHANGES_P:
        return None
    return CycleChange(float(np.std([piece.mean() for piece in cycles if piece.size])))


def p_among_cycles(base: Solution, grown: Solution) -> float:
    """Return p of an effect whose sample is the cycles of the reference, by the F test of the
    cycles' means without and with the effect; 0 if the effect also changes within the cycles.

    ``grown``: solution of the same rows with the effect. Its noise knows no jumps between the
    cycles, so that one of them may look like the effect.
    """
    rows, before = base.observations.reference, base.reference_residual_arcsec()
    after = grown.reference_residual_arcsec()
    if rows is None or rows.cycle is None or before is None or after is None:
        return 0.0
    ends = np.flatnonzero((np.diff(rows.run) != 0) | (np.diff(rows.cycle) != 0)) + 1
    taken = before - after
    pieces = np.split(taken - taken.mean(), ends)
    between = np.array([piece.mean() for piece in pieces])
    within = sum(float(np.sum((piece - piece.mean()) ** 2)) for piece in pieces)
    free = between.size - 2
    if free < 1 or within > MOST_WITHIN * float(np.sum(taken**2)):
        return 0.0
    means = np.array([piece.mean() for piece in np.split(before, ends)])
    means = means - means.mean()
    shape = between - between.mean()
    explained = float(means @ shape) ** 2 / max(float(shape @ shape), 1e-300)
    left = max(float(means @ means) - explained, 1e-300)
    return float(fdtrc(1, free, explained * free / left))


def _change(values: Float) -> float:
    return float(values[SIDE_ROWS:].mean() - values[:SIDE_ROWS].mean())
