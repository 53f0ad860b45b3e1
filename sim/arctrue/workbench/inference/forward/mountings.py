"""Tests whether each run of a reference has its own zero and its own order 1.

A head or a reference that is clamped again before each run has another zero and another
eccentricity in each run. One change between two runs, or a growth with time, does not describe
these changes.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from arctrue.workbench.inference.forward.cycles import CHANGES_P, CycleChange
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.numeric.harmonics import harmonic_columns
from arctrue.workbench.observations import ReferenceRows

Float = NDArray[np.float64]

LEAST_RUNS = 4
"""Fewest runs: with three, one change and a growth describe every order of the runs."""
HIGHEST = 4
"""Orders 2 to HIGHEST of each run show how much noise differs between the runs. A random walk, a
step within a run and a drift over many runs have coefficients that fall with 1/n, so that n² times
the square of order n is at least the square of order 1. An oscillation with a period of one or two
runs has smaller coefficients of these orders; it is excluded by the changes at the boundaries of
the runs."""
LEAST_TURN = 0.75
"""Smallest part of a turn that a run must cover, as for an order of a product of parts."""
LEAST_ROWS = 12
"""Fewest rows of a run, for the nine coefficients of its zero and its orders 1 to HIGHEST."""
ZERO_SHARE = 0.5
"""Smallest ratio of the scatter of the zeros to that of order 1. An oscillation of about one period
a run also has another order 1 in each run, but it averages to nearly zero over a run: with a period
of one to 1.4 runs, the ratio is at most 0.43 (sinc 0.7 / sinc 0.3). A random walk of the zero makes
the ratio larger; it is excluded by the changes at the boundaries."""
EDGE = 3
"""Number of rows whose mean is compared on each side of a boundary of two runs: a drift is
continuous there, and only a change between the runs causes a jump."""
LEAST_JUMP = 0.7
"""Smallest ratio of the jumps' scatter to that of the difference of two independent zeros, which is
√2 times the scatter of the zeros. Such zeros have a ratio of 1 or more on average, because order 1
also jumps."""
MORE_THAN_INSIDE = 2.0
"""Smallest ratio of the jumps' scatter to that of such differences inside the runs. A sine that is
steepest at every boundary reaches √2; a random walk over six runs, with four free jumps, reaches 2
with a probability of 0.3 % (χ²)."""
MOST_LEFT = 0.2
"""Smallest share of the squares of the runs' order 1 that must remain with an effect or a product
in the model. By chance, one factor of the runs describes about a fifth of the changes of six runs,
and the best of a dozen factors about a half."""


def mounting_change(solution: Solution) -> CycleChange | None:
    """Return the scatter of zero and order 1 between the runs; None if the runs do not show their
    own order 1 and their own zero, if the error is continuous from run to run, or if the set has a
    capture, whose effects then decide."""
    found = _of_runs(solution)
    if found is None or solution.observations.capture is not None or solution.unknown_noise:
        return None
    zeros, orders, jumps, inside = found
    free = zeros.size - 1
    square = _squares(orders[0])
    noise = np.mean([number**2 * _squares(one) for number, one in enumerate(orders[1:], 2)])
    ratio = square / max(float(noise), 1e-300)
    if float(fdtrc(2 * free, 2 * (HIGHEST - 1) * free, ratio)) >= CHANGES_P:
        return None
    zero, order_1 = float(np.std(zeros)), float(np.sqrt(square / zeros.size))
    if zero < ZERO_SHARE * order_1:
        return None
    if jumps < max(LEAST_JUMP * np.sqrt(2.0) * zero, MORE_THAN_INSIDE * inside):
        return None
    return CycleChange(zero, of_runs=True, order_1_arcsec=order_1)


def describes_mountings(base: Solution, grown: Solution) -> bool:
    """Tell whether an effect in the model ``grown`` describes the order 1 of the runs."""
    before, after = _of_runs(base), _of_runs(grown)
    if before is None or after is None:
        return True
    return _squares(after[1][0]) < MOST_LEFT * _squares(before[1][0])


def _of_runs(solution: Solution) -> tuple[Float, list[Float], float, float] | None:
    """Return the zero, (runs,), and for each order its cosine and sine, (runs, 2), of each run of
    the reference, and the scatter of the steps between and inside the runs; None if a run is too
    short, if there are too few runs, or if the rows are not sorted by run."""
    rows, left = solution.observations.reference, solution.reference_residual_arcsec()
    if rows is None or left is None or np.any(np.diff(rows.run) < 0):
        return None
    if rows.direction is not None:
        # A reversal error also changes the zeros.
        for side in np.unique(rows.direction):
            own = rows.direction == side
            left = np.where(own, left - left[own].mean(), left)
    pieces = np.split(np.arange(left.size), np.flatnonzero(np.diff(rows.run) != 0) + 1)
    if len(pieces) < LEAST_RUNS or not all(_is_turn(rows, piece) for piece in pieces):
        return None
    fitted = []
    for piece in pieces:
        waves = harmonic_columns(rows.angle_rad[piece], range(1, HIGHEST + 1))
        columns = np.hstack([np.ones((piece.size, 1)), waves])
        fitted.append(np.linalg.lstsq(columns, left[piece], rcond=1e-6)[0])
    coefficients = np.array(fitted)
    return (
        coefficients[:, 0],
        [coefficients[:, 2 * order - 1 : 2 * order + 1] for order in range(1, HIGHEST + 1)],
        *_steps([left[piece] for piece in pieces]),
    )


def _steps(runs: list[Float]) -> tuple[float, float]:
    """Return the scatter of the steps at the boundaries of the runs, about their mean, and the rms
    of the same steps inside the runs. The mean step contains the changes that all boundaries have
    in common. These are the table's error between the last place of a run and the first place of
    the next run, and an even drift; the model's orders absorb the part of this drift within a
    run."""
    means = [np.convolve(run, np.full(EDGE, 1.0 / EDGE), mode="valid") for run in runs]
    jumps = np.array([after[0] - before[-1] for before, after in pairwise(means)])
    inside = np.concatenate([mean[EDGE:] - mean[:-EDGE] for mean in means])
    return float(np.std(jumps, ddof=1)), float(np.sqrt(np.mean(inside**2)))


def _is_turn(rows: ReferenceRows, piece: NDArray[np.int64]) -> bool:
    covered = float(np.ptp(rows.target_rad[piece])) * (1.0 + 1.0 / piece.size)
    return piece.size >= LEAST_ROWS and covered >= LEAST_TURN * 2.0 * np.pi


def _squares(coefficients: Float) -> float:
    """Return the sum of squares of an order's coefficients about their mean over the runs."""
    return float(np.sum((coefficients - coefficients.mean(axis=0)) ** 2))
