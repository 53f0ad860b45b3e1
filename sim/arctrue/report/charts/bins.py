"""Averages rows in bins, so that a picture of 72,000 rows is readable."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

TURN_BINS = 180
"""Number of bins in a turn; each bin is two degrees wide."""


@dataclass(frozen=True)
class Bins:
    """Mean values of the bins that contain rows; every array has the shape (bins,)."""

    centre: Float
    mean: Float
    low: Float
    high: Float
    standard_error: Float
    """Standard error of each mean if the rows are independent; 0 in a bin with a single row."""
    rows: Integer


def of_groups(values: Float, group: Integer, centres: Float) -> Bins:
    """Return the means of the rows in each bin; ``group``, shape (rows,), is the number of the bin
    of each row."""
    size = centres.size
    rows = np.bincount(group, minlength=size)
    there = rows > 0
    counts = np.maximum(rows, 1)
    mean = np.bincount(group, values, size) / counts
    square = np.bincount(group, (values - mean[group]) ** 2, size)
    low, high = np.full(size, np.inf), np.full(size, -np.inf)
    np.minimum.at(low, group, values)
    np.maximum.at(high, group, values)
    error = np.sqrt(square / np.maximum(rows - 1, 1) / counts)
    return Bins(centres[there], mean[there], low[there], high[there], error[there], rows[there])


def of_turn(angle_rad: Float, values: Float, bins: int = TURN_BINS) -> Bins:
    """Return the means of the rows in equal bins over the turn, at the bins' centres in degrees."""
    group = turn_group(angle_rad, bins)
    return of_groups(values, group, (np.arange(bins) + 0.5) * 360.0 / bins)


def turn_group(angle_rad: Float, bins: int) -> Integer:
    """Return the number of the turn's bin for each angle."""
    part = np.mod(angle_rad / (2.0 * np.pi), 1.0)
    return np.minimum((part * bins).astype(np.int64), bins - 1)


def of_values(condition: Float, values: Float, bins: int = 24) -> Bins:
    """Return the means of the rows in bins over a condition: one bin per value if there are few
    values, otherwise bins of equal width."""
    names, group = np.unique(condition, return_inverse=True)
    if names.size <= bins:
        return of_groups(values, group.astype(np.int64), names.astype(np.float64))
    low, high = float(condition.min()), float(condition.max())
    step = (high - low) / bins
    group = np.minimum(((condition - low) / step).astype(np.int64), bins - 1)
    # All rows of a bin may lie at one end of the bin, so each mean is drawn at the mean condition
    # of its rows.
    rows = np.maximum(np.bincount(group, minlength=bins), 1)
    return of_groups(values, group, np.bincount(group, condition, bins) / rows)
