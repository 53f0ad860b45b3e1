"""Calculates the standard deviation of the estimated position of a step, in samples."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

SMALL_STEP = 0.3
"""If the ratio of step to noise is below this value, the variance for small steps, LIMIT_VARIANCE,
is right to a few percent."""
LIMIT_VARIANCE = 26.0
"""Variance of the position (in samples²) times (step/noise)⁴ for small steps: Yao, Ann. Statist. 15
(1987) 1321."""
WALKS = 4000
"""Number of simulated walks for each ratio: they give the standard deviation of the position to 1
%, 1/√(2·4000)."""
LARGE_STEP = 12.0
"""If the ratio of step to noise exceeds this value, the estimated row counts as the true row: a
neighbouring row is as improbable as normal noise beyond 6 σ, 10⁻⁹."""
LEAST_STEP = 1e-6
"""If the ratio of step to noise is below this value, there is no step: with LIMIT_VARIANCE, the
standard deviation of its position is 10¹² rows or more."""
SEED = 1
"""Seed of the walks, fixed so that equal steps have equal uncertainties."""


def position_sigma_samples(step: float, noise: float) -> float:
    """Return the standard deviation, in samples, of the most likely position of a step in white
    noise.

    With δ = step/noise, the log likelihood is a random walk that starts at the true position in
    both directions; its steps have the mean −δ²/2 and the variance δ². The estimated position is
    the highest point of the walk.
    """
    if noise <= 0.0 or step > LARGE_STEP * noise:
        return 0.0
    if step < LEAST_STEP * noise:
        return float("inf")
    ratio = step / noise
    if ratio < SMALL_STEP:
        return float(np.sqrt(LIMIT_VARIANCE)) / ratio**2
    # The ratio is rounded, so that the walks of one ratio are drawn once.
    return _walked(float(f"{ratio:.3g}"))


@lru_cache(maxsize=64)
def _walked(ratio: float) -> float:
    random = np.random.default_rng(SEED)
    length = int(np.ceil(80.0 / ratio**2)) + 2
    highest, place = np.zeros(WALKS), np.zeros(WALKS)
    for side in (-1.0, 1.0):
        steps = random.normal(-0.5 * ratio**2, ratio, (WALKS, length))
        walk = np.cumsum(steps, axis=1)
        top = np.argmax(walk, axis=1)
        value = walk[np.arange(WALKS), top]
        higher = value > highest
        highest = np.where(higher, value, highest)
        place = np.where(higher, side * (top + 1), place)
    return float(np.sqrt(np.mean(place**2)))
