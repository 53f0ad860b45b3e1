"""Finds several heads of a capture that step at one instant, which no slip of one head explains."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Nonlinear
from arctrue.workbench.inference.residuals import Residuals

Float = NDArray[np.float64]

SIDE = 16
"""Largest number of samples before and after the instant whose means are compared: a step is local,
and a fit without it smears the step over the run."""
LEAST_SIDE = 4
"""Smallest number of such samples; their scatter must be known."""
SURE = 6.0
"""Smallest step in standard uncertainties from 16 samples; it equals the limit of recurring slips
(:mod:`arctrue.workbench.diagnose.equal_slips`)."""


def heads_that_step(residuals: Residuals, place: Nonlinear) -> str | None:
    """Return in words which heads step at the place of a slip, and by how many counts; None if
    fewer than two heads step, or if the capture has only two heads.

    A head steps if its reading changes by another size than most heads; of two pairs, the pair
    without head 1 steps.
    """
    rows, left = residuals.observations.capture, residuals.capture_arcsec
    count = residuals.observations.count_arcsec
    if rows is None or rows.channel is None or left is None or count is None:
        return None
    found = round(place["run"])
    run = found // rows.channels if found >= 0 else -found - 1
    inside = rows.run // rows.channels == run
    channels = np.stack([left[inside & (rows.channel == n)] for n in range(rows.channels)])
    times = rows.time_s[inside & (rows.channel == 0)]
    first = int(np.searchsorted(times, place["instant"]))
    before, after = channels[:, max(first - SIDE, 0) : first], channels[:, first : first + SIDE]
    if min(before.shape[1], after.shape[1]) < LEAST_SIDE:
        return None
    # Readings of every head against those of head 1.
    back = np.linalg.inv(rows.weights)
    sizes = np.append(0.0, back @ (after.mean(axis=1) - before.mean(axis=1))) / count
    variances = [np.var(back @ part, axis=1, ddof=1) / part.shape[1] for part in (before, after)]
    sigma = float(np.sqrt(np.max(np.sum(variances, axis=0)))) / count
    near = np.abs(sizes[:, np.newaxis] - sizes) < SURE * max(sigma, 1.0 / SURE)
    still = near[int(np.argmax(near.sum(axis=1)))]
    steps = sizes - sizes[still].mean()
    if int(np.sum(~still)) < 2:
        return None
    heads = [f"{head + 1}" for head in np.flatnonzero(~still)]
    counts = [f"{steps[head]:+.0f}" for head in np.flatnonzero(~still)]
    return (
        f"heads {' and '.join(heads)} step at the same instant, by {' and '.join(counts)} counts; "
        "a slip changes one head"
    )
