"""Finds the step in which an instrument shows its values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

LEAST_AGAIN = 2.0
"""Times that a rounded value comes again: a file of fewer digits than its noise has more."""
SAME_VALUE = 1e-12
"""Relative difference up to which two values of a file are equal except for their last bit."""
WHOLE_STEPS = 0.01
"""Largest deviation from a whole number of steps that the decimals of a file cause, in steps."""


def display_step(values: Float) -> float:
    """Step in which an instrument shows its values, 0 where they are not rounded; (rows,) → step.

    The smallest difference of two values, where every difference is a whole number of it and a
    value comes again LEAST_AGAIN times in the mean: values of 64 bits come again only if rounded.
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
