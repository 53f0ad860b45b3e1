"""Tests whether an error of the runs that is taken for a delay grows in proportion to the speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from arctrue.workbench.diagnose.candidate import Candidate, changes_arcsec
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations import ReferenceRows

Float = NDArray[np.float64]

SURE_P = 1e-4
"""Largest p of a sure result; it equals the limit for a lack of fit."""
LEAST_SPEEDS = 4
"""Fewest speeds: a sign and a slope describe any error of two speeds, and of three speeds a single
one would decide."""
LEAST_FREE = 3
"""Fewest degrees of freedom of the runs besides the speeds."""
SAME_SPEED = 0.02
"""Largest relative difference of two speeds that count as the same; a drive repeats a set speed
within a few per mille."""
IN_PROPORTION = 0.98
"""Smallest share of the squares of an effect's run means that a straight line through zero
explains, for an effect that is in proportion to the speed; the order-dependent part of a delay
averages to less."""


def not_in_proportion(base: Solution, best: Candidate, least_share: float) -> str | None:
    """Explain in words why an effect in proportion to the speed does not describe the runs of a
    reference; None if it may, or for any other effect.

    The part of the run means that changes its sign with the direction is compared with a step and
    a straight line (a reversal error and a delay). The rest of the run means is the noise of the
    F test. ``least_share``: smallest share of the sum of squares of the straight line, beyond the
    step, that the departure from it must reach.
    """
    rows, left = base.observations.reference, base.reference_residual_arcsec()
    if rows is None or left is None or rows.speed_rad_s is None:
        return None
    speed, means = _of_runs(rows, rows.speed_rad_s), _of_runs(rows, left)
    change = _of_runs(rows, changes_arcsec(base, best.solution)["reference"])
    if not _is_line(speed, change):
        return None
    size = np.abs(speed)
    order = np.argsort(size)
    new = np.diff(size[order], prepend=-1.0) > SAME_SPEED * size[order]
    level = np.empty(size.size, dtype=np.int64)
    level[order] = np.cumsum(new) - 1
    levels = int(level.max()) + 1
    free = means.size - 1 - levels
    if levels < LEAST_SPEEDS or free < LEAST_FREE or np.unique(np.sign(speed)).size < 2:
        return None
    sign = np.sign(speed)
    odd = sign[:, np.newaxis] * (level[:, np.newaxis] == np.arange(levels))
    one = np.ones((means.size, 1))
    step = np.hstack([one, sign[:, np.newaxis]])
    line = np.hstack([step, speed[:, np.newaxis]])
    of_step, of_line = _squares_left(step, means), _squares_left(line, means)
    of_levels = _squares_left(np.hstack([one, odd]), means)
    departs, follows = of_line - of_levels, of_step - of_line
    if departs <= least_share * follows:
        return None
    ratio = departs / (levels - 2) / max(of_levels / free, 1e-300)
    if float(fdtrc(levels - 2, free, ratio)) >= SURE_P:
        return None
    halves = np.linalg.lstsq(np.hstack([one, odd]), means, rcond=None)[0][1:]
    speeds = [float(np.degrees(size[level == number].mean())) for number in range(levels)]
    listed = ", ".join(f"{value:.2g}″" for value in halves)
    return (
        f"the offsets of the runs do not grow in proportion to the speed: ±({listed}) at "
        f"{', '.join(f'{value:.3g}' for value in speeds)}°/s up and down"
    )


def _of_runs(rows: ReferenceRows, values: Float) -> Float:
    pieces = np.split(values, np.flatnonzero(np.diff(rows.run) != 0) + 1)
    return np.array([piece.mean() for piece in pieces])


def _is_line(speed: Float, change: Float) -> bool:
    """Tell whether the change of the run means is in proportion to the speed."""
    away = change - change.mean()
    square = float(away @ away)
    line = speed - speed.mean()
    explained = float(line @ away) ** 2 / max(float(line @ line), 1e-300)
    return square > 0.0 and explained >= IN_PROPORTION * square


def _squares_left(columns: Float, values: Float) -> float:
    left = values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(left @ left)
