"""Finds the step to which an instrument rounds its values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

LEAST_AGAIN = 2.0
"""Values count as rounded if each different value occurs at least this number of times on average.
If the rounding step is larger than the noise, values recur more often than this.
"""
SAME_VALUE = 1e-12
"""Largest difference of two equal values of a file, relative to the largest value: the last bits
may differ.
"""
WHOLE_STEPS = 0.01
"""Largest deviation from a whole number of steps, in steps, that the decimals of a file may
cause."""


def display_step(values: Float) -> float:
    """Return the step to which an instrument rounds its values (rows,); 0 if they are not rounded.

    The step is the smallest difference of two values. Two conditions must hold: every difference is
    a whole number of steps, and each value occurs LEAST_AGAIN times on average, because values of
    64 bits recur only if they are rounded.
    """
    different = np.unique(values)
    if different.size < 2 or values.size < LEAST_AGAIN * different.size:
        return 0.0
    steps = np.diff(different)
    step = float(steps[steps > SAME_VALUE * float(np.abs(values).max())].min(initial=np.inf))
    if not np.isfinite(step):
        return 0.0
    whole = steps / step
    return step if bool(np.all(np.abs(whole - np.round(whole)) < WHOLE_STEPS)) else 0.0
