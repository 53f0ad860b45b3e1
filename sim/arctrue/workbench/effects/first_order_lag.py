"""Calculates a recorded condition T after a first-order lag: T_b with T_b′ = (T − T_b)/τ."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]


def behind(values: Float, time_s: Float, lag_s: float) -> Float:
    """Return the condition after a first-order lag. The lag begins in equilibrium with the first
    value; between the rows, the condition is a straight line."""
    steps = np.diff(time_s)
    kept = np.exp(-steps / lag_s)
    slack = lag_s * np.diff(values) / steps
    # Exact for a straight line: T_b = T − τ·T′ + (T_b − T + τ·T′)₀·e^(−t/τ)
    added = values[1:] - slack - kept * (values[:-1] - slack)
    found = [float(values[0])]
    for share, further in zip(kept.tolist(), added.tolist(), strict=True):
        found.append(share * found[-1] + further)
    return np.array(found)


def both_ways(values: Float, time_s: Float, lag_s: float) -> Float:
    """Return the condition after symmetric smoothing: the mean of a lag forwards in time and a lag
    backwards in time."""
    back = behind(values[::-1], -time_s[::-1], lag_s)[::-1]
    return 0.5 * (behind(values, time_s, lag_s) + back)
