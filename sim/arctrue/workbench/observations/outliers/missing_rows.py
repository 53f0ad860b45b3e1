"""Gaps of a run, in which rows are missing, and the pieces between them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from arctrue.workbench.observations.outliers.far_rows import SIDE_ROWS

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

LEAST_ROWS = 3 * SIDE_ROWS
"""Smallest number of rows of a run, or of a pass with closely spaced rows, in which a single wrong
row can be recognised."""
WAVE_ORDERS = 20
"""Number of orders, as in the paper's model, that are subtracted before rows on both sides of a gap
are compared."""
WAVE_CONDITION = 1e-6
"""The fit of the wave sets singular values below this share of the largest one to zero, because the
rows of an arc cannot separate all orders."""
MOST_FITTED = 20_000
"""The wave of a longer run is fitted to evenly spread rows; their number is at least this value and
less than twice this value."""


def gaps(angle: Float) -> Integer:
    """Return the numbers of the steps over missing rows in a run; ``angle``: (rows,).

    Step k leads from row k to row k + 1. A step over missing rows is larger than SIDE_ROWS times
    the mean step of the run and than SIDE_ROWS times the median step around it, so that a changing
    speed causes no gap.
    """
    step = np.abs(np.diff(angle))
    long = np.flatnonzero(step > SIDE_ROWS * float(np.mean(step))) if step.size else step
    found = []
    for place in long.astype(np.int64).tolist():
        around = step[max(place - SIDE_ROWS, 0) : place + SIDE_ROWS + 1]
        if step[place] > SIDE_ROWS * float(np.median(around)):
            found.append(place)
    return np.array(found, dtype=np.int64)


def pieces_between_gaps(angle: Float) -> list[slice]:
    """Return the pieces of a run between gaps, LEAST_ROWS or more each; ``angle``: (rows,).

    A piece of fewer rows than LEAST_ROWS is joined to its neighbour.
    """
    cuts = [0]
    for place in gaps(angle).tolist():
        first = place + 1
        if first - cuts[-1] >= LEAST_ROWS and angle.size - first >= LEAST_ROWS:
            cuts.append(first)
    return [slice(start, end) for start, end in pairwise([*cuts, angle.size])]


def without_wave(values: Float, angle_rad: Float) -> Float:
    """Subtract the mean and the first WAVE_ORDERS orders of the turn, if there are gaps; (rows,).

    The wave is fitted to running medians, in short runs with fewer orders. Without the wave, the
    values on both sides of a gap agree, so that the few rows between two gaps are not far from the
    rows beyond the gaps. Values without gaps are not changed.
    """
    if gaps(angle_rad).size == 0:
        return values
    thin = slice(None, None, max(values.size // MOST_FITTED, 1))
    medians = median_filter(values, size=SIDE_ROWS, mode="nearest")[thin]
    orders = np.arange(1, min(WAVE_ORDERS, values.size // (4 * SIDE_ROWS)) + 1)
    phase = np.outer(angle_rad[thin], orders)
    columns = np.column_stack([np.ones(medians.size), np.cos(phase), np.sin(phase)])
    found = np.linalg.lstsq(columns, medians, rcond=WAVE_CONDITION)[0]
    flat = values - found[0]
    for order, even, odd in zip(orders, *np.split(found[1:], 2), strict=True):
        flat -= even * np.cos(order * angle_rad) + odd * np.sin(order * angle_rad)
    return np.asarray(flat)
