"""Tests whether the offset of a reference changes between its cycles or runs.

A mirror or polygon that moves when the table reverses or waits shifts every reading of a cycle.
Slow noise changes as much within a cycle as between two cycles, so that the changes at the ends of
the cycles are compared with the changes within them.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from arctrue.workbench.inference.forward.speed_levels import speed_levels
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.law import reference_clock

Float = NDArray[np.float64]

SIDE_ROWS = 4
"""Rows on each side of a change, whose means are compared: a cycle of 24 faces has three such
pairs, and slow noise changes as much over four rows within a cycle as between cycles."""
LEAST_ENDS, LEAST_INSIDE = 4, 8
"""Fewest changes between and within cycles: with four and eight, F must exceed 27 at CHANGES_P."""
CHANGES_P = 1e-4
"""Largest p at which the offset is stated to change; it equals the limit of a sure lack of fit."""


MOST_WITHIN = 0.1
"""If at most this share of an effect's sum of squares lies within the cycles, the effect is tested
by the means of the cycles."""


@dataclass(frozen=True)
class CycleChange:
    """An offset of the reference that changes from cycle to cycle, or from run to run."""

    rms_arcsec: float
    """Standard deviation of the means of the cycles or runs."""
    of_runs: bool = False
    order_1_arcsec: float = 0.0
    """RMS over the runs of the change of the amplitude vector of order 1 from its mean; 0 if only
    the zeros change."""
    by_speed: str = ""
    """Speed or direction that the offsets of the runs follow, and their sizes, in words; empty if
    they follow neither."""
    explained_by: tuple[str, ...] = ()
    """Effects that explain the offsets together; empty if nothing explains them."""

    def words(self) -> str:
        """Return the detection in words."""
        if self.explained_by:
            what = "run to run" if self.of_runs else "cycle to cycle"
            return (
                f"the offset of the reference changes from {what} by {self.rms_arcsec:.2g}″ RMS, "
                f"which {' and '.join(self.explained_by)} explain together"
            )
        if self.order_1_arcsec:
            return (
                f"each run of the reference has its own zero and its own order 1, which scatter by "
                f"{self.rms_arcsec:.2g}″ and {self.order_1_arcsec:.2g}″ RMS, as if a head or the "
                "reference was clamped again before each run"
            )
        if self.by_speed:
            return (
                f"the offset of the reference changes from run to run by {self.rms_arcsec:.2g}″ "
                f"RMS and follows the {self.by_speed}"
            )
        if self.of_runs:
            return (
                f"the offset of the reference changes from run to run by {self.rms_arcsec:.2g}″ "
                "RMS: each run has its own zero"
            )
        return (
            f"the offset of the reference changes from cycle to cycle by {self.rms_arcsec:.2g}″ "
            "RMS: the mirror or its mounting moved between the cycles"
        )


def cycle_change(solution: Solution, largest_p: float = CHANGES_P) -> CycleChange | None:
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
    if float(fdtrc(len(between), len(inside), ratio)) >= largest_p:
        return None
    return CycleChange(float(np.std([piece.mean() for piece in cycles if piece.size])))


LEAST_RUN_ENDS = 2
"""Fewest changes between runs: with two and eight within runs, F must exceed 36 at CHANGES_P."""
SIDE_SHARE = 20
"""A side of a change between runs has 1/SIDE_SHARE of the rows of the shortest run: the noise of
its mean is then about four times that of the mean of a run."""
LEAST_SIDE = 2
"""Fewest rows of a side. Runs of 24 faces with a pause of seven steps have eight changes within
four runs if a side has two rows, and four changes if it has SIDE_ROWS."""
LEFT_OF_CHANGES = 0.25
"""Largest share of the sum of squared changes that differences of the runs' means may leave
unexplained: an offset lasts for its run, but a transient after a reversal does not."""


def run_change(solution: Solution, largest_p: float = CHANGES_P) -> CycleChange | None:
    """Return the change of the offset between the runs of a reference without cycles; None if the
    runs do not show one.

    The changes over the pauses are compared with changes over the same time within the runs, in
    which slow noise changes as much. The means of both directions are removed first.
    """
    rows, left = solution.observations.reference, solution.reference_residual_arcsec()
    if rows is None or left is None or rows.cycle is not None or solution.unknown_noise:
        return None
    levels = speed_levels(rows, left, least_speeds=1)
    if rows.direction is not None:
        for side in np.unique(rows.direction):
            own = rows.direction == side
            left = np.where(own, left - left[own].mean(), left)
    clock = reference_clock(rows)
    ends = np.flatnonzero(np.diff(rows.run) != 0) + 1
    runs = np.split(left, ends)
    shortest = min(piece.size for piece in runs)
    steps = np.diff(clock)[np.diff(rows.run) == 0]
    side = max(SIDE_ROWS, shortest // SIDE_SHARE)
    if ends.size < LEAST_RUN_ENDS or float(np.median(steps)) <= 0.0:
        return None
    pauses = (clock[ends] - clock[ends - 1]) / float(np.median(steps))
    if float(pauses.min()) < 0.0 or float(pauses.max()) > shortest:
        return None
    apart = max(round(float(pauses.max())) - 1, 0)
    inside = _changes_inside(runs, side, apart)
    while len(inside) < LEAST_INSIDE and side > LEAST_SIDE:
        side -= 1
        inside = _changes_inside(runs, side, apart)
    if len(inside) < LEAST_INSIDE:
        return None
    change = np.array(
        [after[:side].mean() - before[-side:].mean() for before, after in pairwise(runs)]
    )
    of_means = np.diff([piece.mean() for piece in runs])
    square, noise = float(change @ change), max(float(np.mean(np.square(inside))), 1e-300)
    if float(np.sum((change - of_means) ** 2)) > LEFT_OF_CHANGES * square:
        return None
    if float(fdtrc(change.size, len(inside), square / change.size / noise)) >= largest_p:
        return None
    by_speed = ""
    if levels is not None and levels.follow_the_speed():
        by_speed = f"{'speed' if levels.number > 1 else 'direction'}: {levels.words()}"
    rms = float(np.std([piece.mean() for piece in runs]))
    return CycleChange(rms, of_runs=True, by_speed=by_speed)


def _changes_inside(runs: list[Float], side: int, apart: int) -> list[float]:
    """Return the changes within the runs, of means over ``side`` rows with ``apart`` rows between
    them."""
    return [
        float(piece[start + side + apart :][:side].mean() - piece[start:][:side].mean())
        for piece in runs
        for start in range(0, piece.size - 2 * side - apart + 1, 2 * side + apart)
    ]


def p_among_cycles(base: Solution, grown: Solution) -> float:
    """Return p of an effect that changes only between the cycles (or runs) of the reference, by the
    F test of their means without and with the effect; 0 if it also changes within them.

    ``grown``: solution of the same rows with the effect. The noise of this solution contains no
    jumps between the cycles, so that such a jump may look like the effect.
    """
    before, after = base.reference_residual_arcsec(), grown.reference_residual_arcsec()
    if before is None or after is None:
        return 0.0
    shape, only = between_cycles(base, before - after)
    free = shape.size - 2
    if free < 1 or not only:
        return 0.0
    means = between_cycles(base, before)[0]
    explained = float(means @ shape) ** 2 / max(float(shape @ shape), 1e-300)
    left = max(float(means @ means) - explained, 1e-300)
    return float(fdtrc(1, free, explained * free / left))


def between_cycles(base: Solution, values: Float) -> tuple[Float, bool]:
    """Return the means of the cycles (or runs) of the reference, minus the mean of these means, and
    whether ``values``, (rows,), change only between them."""
    rows = base.observations.reference
    assert rows is not None
    change = np.diff(rows.run) != 0
    if rows.cycle is not None:
        change |= np.diff(rows.cycle) != 0
    pieces = np.split(values - values.mean(), np.flatnonzero(change) + 1)
    means = np.array([piece.mean() for piece in pieces])
    within = sum(float(np.sum((piece - piece.mean()) ** 2)) for piece in pieces)
    only = within <= MOST_WITHIN * float(np.sum(values**2))
    return means - means.mean(), only


def _change(values: Float) -> float:
    return float(values[SIDE_ROWS:].mean() - values[:SIDE_ROWS].mean())
