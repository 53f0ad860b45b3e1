"""Computes the Allan deviation of a series, which shows how the means of a given number of readings
drift.

The deviation of white noise falls as 1/√m with the number m of averaged readings; the deviation of
a drift of D per reading rises as D·m/√2. The longest useful mean has the m at which both are equal
(NIST SP 1065, 5.2).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def overlapping_allan_deviation(
    values: ArrayLike, averaged: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Compute the overlapping Allan deviation, σ²(m) = ½⟨(ȳ_{k+m} − ȳ_k)²⟩, where ȳ is a mean of m
    readings.

    ``values`` (n,): evenly spaced readings, NaN for a missing one; a pair of means with a missing
    reading is left out. ``averaged`` (k,): numbers m of readings in a mean.

    Returns the deviation (k,) in the unit of the values, NaN if no pair is complete, and the number
    of pairs (k,). Raises ValueError if an m is not a whole number of at least 1.
    """
    readings = np.asarray(values, dtype=np.float64)
    lengths = np.atleast_1d(np.asarray(averaged))
    if readings.ndim != 1 or lengths.ndim != 1:
        raise ValueError("expected a series of readings and a list of lengths")
    if np.any(lengths != np.floor(lengths)) or np.any(lengths < 1):
        raise ValueError(f"lengths: expected whole numbers from 1 on, found {lengths.tolist()}")
    missing = np.concatenate([[0], np.cumsum(~np.isfinite(readings))])
    sums = np.concatenate([[0.0], np.cumsum(np.where(np.isfinite(readings), readings, 0.0))])
    deviation = np.full(lengths.size, np.nan)
    pairs = np.zeros(lengths.size, dtype=np.int64)
    for place, length in enumerate(lengths.astype(np.int64).tolist()):
        if 2 * length > readings.size:
            continue
        whole = missing[2 * length :] == missing[: missing.size - 2 * length]
        middle = sums[length : sums.size - length]
        second = sums[2 * length :] - 2.0 * middle + sums[: sums.size - 2 * length]
        pairs[place] = int(whole.sum())
        if pairs[place]:
            deviation[place] = np.sqrt(0.5 * np.mean((second[whole] / length) ** 2))
    return deviation, pairs
