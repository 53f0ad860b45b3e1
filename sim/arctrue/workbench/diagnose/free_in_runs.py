"""An oscillation in time is there at every speed; one run alone may be an order of the angle."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.effects.base import Effect

SAME_SPEED = 1.2
"""Speeds within this ratio are one."""
LEAST_SHARE = 1.0 / 3.0
"""Of the gain that the rows at other speeds would give if it were as large there."""


def at_other_speeds(item: Candidate) -> bool:
    """False for an effect that is free in each run and shows at one of several speeds only.

    What has a size and phase of its own in every run can take the place of any order in a single
    run: warmth, for instance, that makes an order in the warm run. A frequency would be seen at
    the other speeds too.
    """
    rows = item.solution.observations.capture
    if rows is None:
        return True
    own = _of_runs(item.effect, item)
    if rows.runs < 2 or not any(own):
        return True
    part = item.solution.part(len(item.solution.terms) - 1)
    coefficients = item.solution.coefficients[part][own].reshape(rows.runs, -1)
    counts = np.bincount(rows.run, minlength=rows.runs).astype(np.float64)
    first = np.searchsorted(rows.run, np.arange(rows.runs))
    speed = np.abs(rows.speed_rad_s[first])
    gain = counts * np.sum(coefficients**2, axis=1)
    strongest = speed[int(np.argmax(gain))]
    other = (speed > strongest * SAME_SPEED) | (speed < strongest / SAME_SPEED)
    if not other.any() or gain.sum() <= 0.0:
        return True
    expected = float(counts[other].sum() / counts.sum())
    return float(gain[other].sum() / gain.sum()) > LEAST_SHARE * expected


def _of_runs(effect: Effect, item: Candidate) -> list[bool]:
    """Which of its columns belong to one run of the capture."""
    return [" run " in name for name in effect.column_names(item.solution.observations)]
