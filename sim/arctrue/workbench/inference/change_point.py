"""How far the found place of a step scatters from sample to sample."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

SMALL_STEP = 0.3
"""Of the noise: below it the limit for small steps holds to a few percent."""
LIMIT_VARIANCE = 26.0
"""Var of the place · (step/noise)⁴ for small steps: Yao, Ann. Statist. 15 (1987) 1321."""
WALKS = 4000
"""Simulated walks a ratio: a scatter of normal places is then known to 1 %, 1/√(2·4000)."""
LARGE_STEP = 12.0
"""Step over noise from which the place is the right row: a neighbour is then as likely as
normal noise at 6 σ, 10⁻⁹."""
LEAST_STEP = 1e-6
"""Step over noise that is none: LIMIT_VARIANCE puts its place beyond 10¹² rows."""
SEED = 1
"""A fixed one: the same step has the same uncertainty."""


def position_sigma_samples(step: float, noise: float) -> float:
    """Standard deviation, in samples, of the most likely place of a step in white noise.

    The log likelihood of a place m samples off is a random walk with steps of mean −δ²/2 and
    variance δ² to either side, δ = step/noise; the found place is its highest point.
    """
    if noise <= 0.0 or step > LARGE_STEP * noise:
        return 0.0
    if step < LEAST_STEP * noise:
        return float("inf")
    ratio = step / noise
    if ratio < SMALL_STEP:
        return float(np.sqrt(LIMIT_VARIANCE)) / ratio**2
    # Rounded, so that the walks of one ratio are drawn once.
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
