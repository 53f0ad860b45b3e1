"""Finds noise whose level changes with time, such as gusts of wind, in whitened residuals.

The estimated noise has one level. Where the true level is higher, an innovation (whitened residual)
of usual size looks like a step, and products of neighbouring innovations scatter more than in white
noise of one level. Divided by their local RMS, the innovations have one level again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.noise.whiteness import whiteness

Float = NDArray[np.float64]

HALF_WINDOW = 15
"""Rows on each side of a row from which its local RMS is computed. The level is then known to
1/√(2·30) = 13 %, so that dividing by it costs little; a burst shorter than about 30 rows is not
resolved."""
CHANGES_P = 1e-4
"""Largest p at which the level counts as changing; it equals the limit of a sure lack of fit."""
LEAST_RATIO = 2.0
"""Smallest ratio of high to low levels that counts. In noise of one level, the scatter of the local
RMS alone gives (1 + 1.64·0.13)/(1 − 1.64·0.13) = 1.5 between the quantiles of 5 % and 95 %."""
OUTER = 0.05
"""Share of the rows below the low level, and above the high level, that are reported."""
LARGEST = 4.0
"""Innovations above this multiple of the median level count as this multiple in the test: a single
wrong row is not a change of level."""


@dataclass(frozen=True, eq=False)
class NoiseLevel:
    """Level of the noise around each row, if it changes with time."""

    local: Float
    """Local RMS of the innovations around each row, without this row; shape (rows,)."""
    ratio: float
    """High level (exceeded by OUTER of the rows) divided by low level."""


def noise_level(innovations: Float) -> NoiseLevel | None:
    """Return the local level of innovations (rows,); None if it does not change significantly.

    The test is that of Ljung and Box for the absolute values (after McLeod and Li, J. Time Ser.
    Anal. 4 (1983) 269, for squares; absolute values are less sensitive to wild rows).
    """
    if innovations.size < 4 * HALF_WINDOW:
        return None
    size = np.abs(innovations)
    size = np.minimum(size, LARGEST * 1.4826 * max(float(np.median(size)), 1e-300))
    found = whiteness(size)
    if found is None or found.autocorrelation_p >= CHANGES_P:
        return None
    local = _local_rms(innovations)
    low, high = np.quantile(local, [OUTER, 1.0 - OUTER])
    if high < LEAST_RATIO * low:
        return None
    return NoiseLevel(local, float(high / low))


def _local_rms(values: Float) -> Float:
    """Return the RMS of the rows within HALF_WINDOW of each row, without the row itself."""
    sums = np.concatenate([[0.0], np.cumsum(values**2)])
    row = np.arange(values.size)
    first = np.maximum(row - HALF_WINDOW, 0)
    end = np.minimum(row + HALF_WINDOW + 1, values.size)
    square = (sums[end] - sums[first] - values**2) / (end - first - 1)
    return np.asarray(np.sqrt(np.maximum(square, 1e-12 * float(np.mean(values**2)))))
