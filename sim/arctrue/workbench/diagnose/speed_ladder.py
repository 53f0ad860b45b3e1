"""Tests whether an error of the runs that is taken for a delay grows in proportion to the speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from arctrue.workbench.diagnose.candidate import Candidate, changes_arcsec
from arctrue.workbench.inference.forward.speed_levels import (
    SURE_P,
    SpeedLevels,
    of_runs,
    speed_levels,
)
from arctrue.workbench.inference.solution import Solution

Float = NDArray[np.float64]

IN_PROPORTION = 0.98
"""An effect is proportional to the speed if a straight line explains at least this share of the
variance of its run means; the order-dependent part of a delay averages to less than the other 2
%."""
DEPARTS = 0.01
"""Smallest ratio of a departure from a straight line to this line, as sums of squares beyond a
step: a tenth of its size. Between four speeds from 1 to 8, the square of the speed departs by 0.04
and its root by 0.02."""


def not_in_proportion(base: Solution, best: Candidate, matters_arcsec: float) -> str | None:
    """Explain in words why an effect in proportion to the speed does not describe the runs of a
    reference; None if it may, or for any other effect. ``matters_arcsec``: the negligible size."""
    rows, left = base.observations.reference, base.reference_residual_arcsec()
    found = None if rows is None or left is None else speed_levels(rows, left)
    if rows is None or found is None:
        return None
    change = of_runs(rows, changes_arcsec(base, best.solution)["reference"])[found.moving]
    if not _is_line(found.speed_rad_s, change) or not departs_from_a_line(found, matters_arcsec):
        return None
    return f"the offsets of the runs do not grow in proportion to the speed: {found.words()}"


def departs_from_a_line(found: SpeedLevels, matters_arcsec: float) -> bool:
    """Tell whether the part of the run means that changes its sign with the direction is another
    function of the speed than a step and a straight line (a reversal error and a delay).

    The part of the run means that no function of the speed explains is the noise of the F test. The
    RMS of the departure must exceed ``matters_arcsec``.
    """
    speed = found.speed_rad_s
    step = np.column_stack([np.ones(speed.size), np.sign(speed)])
    of_step, of_line = found.left(step), found.left(np.column_stack([step, speed]))
    of_levels = found.left(found.columns)
    departs, follows = of_line - of_levels, of_step - of_line
    if departs <= max(DEPARTS * follows, speed.size * matters_arcsec**2):
        return False
    ratio = departs / (found.number - 2) / max(of_levels / found.free, 1e-300)
    return float(fdtrc(found.number - 2, found.free, ratio)) < SURE_P


def _is_line(speed: Float, change: Float) -> bool:
    """Tell whether the change of the run means is in proportion to the speed."""
    away = change - change.mean()
    square = float(away @ away)
    line = speed - speed.mean()
    explained = float(line @ away) ** 2 / max(float(line @ line), 1e-300)
    return square > 0.0 and explained >= IN_PROPORTION * square
