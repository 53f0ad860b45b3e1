"""Distance of each row from the rows around it, the scatter of this distance, and rows that are far
off alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from arctrue.workbench.numeric.distributions import student_limit

Float = NDArray[np.float64]
Boolean = NDArray[np.bool_]

FAR_SIGMA = 6.0
"""Smallest distance of an outlier, in standard deviations: normal noise of known σ exceeds it once
in 5·10⁸ rows."""
FALSE_ROWS = 0.02
"""Largest mean number of rows of a channel that are beyond the limit of an outlier in white normal
noise, whatever the number of rows."""
MAD_EFFICIENCY = 0.37
"""Efficiency of the median absolute deviation relative to the standard deviation (Rousseeuw and
Croux, J. Am. Stat. Assoc. 88 (1993) 1273): n rows give 0.37·n degrees of freedom."""
NEAR_SIGMA = 3.0
"""Largest deviation, in standard deviations, of the rows next to an outlier, and of the rows at the
same angle in other revolutions."""
MOST_ROWS = 3
"""Largest number of neighbouring outliers; a longer deviation may be real."""
SIDE_ROWS = 2 * MOST_ROWS + 1
"""Number of rows in the median on each side of a row; outliers are always a minority of these
rows."""
LEAST_SIDE_ROWS = 5
"""Smallest number of rows in the median on a side near an end; two wrong rows change this median
only a little."""
TO_MIDDLE = SIDE_ROWS // 2 + 1
"""Distance, in rows, to the middle of the SIDE_ROWS rows before or after a row."""
SCALE_ROWS = 256
"""Number of rows from which one value of the local scatter is calculated."""
END_ROWS = 4 * SCALE_ROWS
"""Number of rows at each end of a run that show how accurately one side predicts a row."""
NORMAL_MAD = 1.4826
"""Standard deviation of normal noise divided by its median absolute deviation."""


def far_threshold(rows: int, scatter_rows: float) -> float:
    """Return the smallest distance of an outlier among ``rows`` rows, in standard deviations, at
    least FAR_SIGMA.

    If the scatter is estimated from ``scatter_rows`` rows, a normal row has Student's t
    distribution: the mean number of normal rows beyond the threshold, on both sides together, is
    then FALSE_ROWS.
    """
    freedom = max(MAD_EFFICIENCY * scatter_rows, 1.0)
    return max(FAR_SIGMA, student_limit(0.5 * FALSE_ROWS / max(rows, 1), freedom))


def local_scatter(away: Float, resolution: float) -> Float:
    """Return the robust standard deviation around each row, (rows,), at least the standard
    deviation of all rows.

    The result is the largest scatter of a stretch of SCALE_ROWS rows and its two neighbour
    stretches, so that rows with larger noise over a part of the turn do not count as outliers.
    Values with steps of ``resolution`` show no scatter below half a step.
    """
    half = 0.5 * resolution
    overall = NORMAL_MAD * max(float(middle(np.abs(away))), half)
    blocks = away.size // SCALE_ROWS
    if blocks < 3:
        return np.full(away.size, overall)
    whole = np.abs(away[: blocks * SCALE_ROWS]).reshape(blocks, SCALE_ROWS)
    each = NORMAL_MAD * np.maximum(middle(whole), half)
    padded = np.concatenate([each[:1], each, each[-1:]])
    largest = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
    scatter = np.repeat(largest, SCALE_ROWS)
    tail = np.full(away.size - scatter.size, largest[-1])
    return np.asarray(np.maximum(np.concatenate([scatter, tail]), overall))


def middle(values: Float) -> Float:
    """Return the mean of the middle fifth along the last axis, (…, rows) → (…).

    This mean replaces a median, which has steps: the median of rounded values is a rounded value,
    or half-way between two.
    """
    last = values.shape[-1] - 1
    low, high = int(np.floor(0.4 * last)), int(np.ceil(0.6 * last))
    return np.asarray(np.partition(values, (low, high), axis=-1)[..., low : high + 1].mean(axis=-1))


def lonely(away: Float, scatter: Float, threshold: float = FAR_SIGMA) -> Boolean:
    """Return True where up to MOST_ROWS consecutive rows are far off and the rows next to these
    rows are not.

    ``away``: distance of each row from the rows around it; ``scatter``: standard deviation of that
    distance. Shapes (rows,). ``threshold``: smallest distance that is far, in standard deviations,
    see :func:`far_threshold`.
    """
    found = np.zeros(away.size, dtype=bool)
    size = np.abs(away)
    far = np.flatnonzero(size > threshold * scatter)
    if far.size == 0:
        return found
    off = size > NEAR_SIGMA * scatter
    breaks = np.flatnonzero(np.diff(far) > 1) + 1
    for group in np.split(far, breaks):
        first, last = int(group[0]), int(group[-1])
        while first > 0 and off[first - 1] and last - first < MOST_ROWS:
            first -= 1
        while last < away.size - 1 and off[last + 1] and last - first < MOST_ROWS:
            last += 1
        if last - first < MOST_ROWS:
            found[group] = True
    return found


def from_both_sides(values: Float) -> Float:
    """Predict the value of each row from the rows before and after it, (rows,).

    The prediction is the mean of two medians, of the SIDE_ROWS rows before and of the SIDE_ROWS
    rows after the row: exact where the values rise evenly, and unaffected by MOST_ROWS wrong rows
    on each side. Near an end, all rows up to the end are used, and the same number of rows on the
    other side. For the first and the last LEAST_SIDE_ROWS rows the prediction is not-a-number;
    :func:`from_one_side` predicts these rows.
    """
    medians = median_filter(values, size=SIDE_ROWS, mode="nearest")
    expected = np.full(values.size, np.nan)
    inner = np.arange(SIDE_ROWS, values.size - SIDE_ROWS)
    expected[inner] = 0.5 * (medians[inner - TO_MIDDLE] + medians[inner + TO_MIDDLE])
    for side in range(LEAST_SIDE_ROWS, min(SIDE_ROWS, values.size // 2)):
        for part, row in (
            (values[: 2 * side + 1], side),
            (values[-2 * side - 1 :], values.size - 1 - side),
        ):
            expected[row] = 0.5 * (np.median(part[:side]) + np.median(part[side + 1 :]))
    return expected


def from_one_side(values: Float) -> Float:
    """Predict the value of each row from the rows after it.

    The prediction is on the straight line through two medians, of the next SIDE_ROWS rows and of
    the SIDE_ROWS rows after these; MOST_ROWS rows of each may be wrong. At the last 2·SIDE_ROWS
    rows the prediction is not-a-number.
    """
    medians = median_filter(values, size=SIDE_ROWS, mode="nearest")
    expected = np.full(values.size, np.nan)
    first = np.arange(values.size - 2 * SIDE_ROWS)
    near, far = medians[first + TO_MIDDLE], medians[first + TO_MIDDLE + SIDE_ROWS]
    expected[first] = near + (near - far) * (TO_MIDDLE / SIDE_ROWS)
    return expected


def far_from_neighbours(
    values: Float, least: float, resolution: float = 0.0, pieces: Sequence[slice] = ()
) -> tuple[Float, Float]:
    """Return the distance of each row from the rows around it, and the standard deviation of that
    distance, at least ``least``.

    ``values``: rows of one run or pass in order, (rows,), in steps of ``resolution``. ``pieces``:
    parts of at least LEAST_ROWS rows, between which rows are missing; if empty, all rows are one
    piece.

    The first and last LEAST_SIDE_ROWS rows of a piece have neighbours on one side only, which
    predict them. The standard deviation of their distance is calculated from the same one-sided
    prediction over the END_ROWS rows at that end; it is larger than for a prediction from both
    sides.
    """
    away = np.full(values.size, np.nan)
    after, before = away.copy(), away.copy()
    for piece in pieces or [slice(0, values.size)]:
        own = values[piece]
        away[piece] = own - from_both_sides(own)
        first, last = own[:END_ROWS], own[-END_ROWS:]
        after[piece][: first.size] = first - from_one_side(first)
        before[piece][-last.size :] = last - from_one_side(last[::-1])[::-1]
    scatter = _scatter_of_all(away, resolution)
    for one_sided in (after, before):
        end = np.isnan(away) & ~np.isnan(one_sided)
        scatter[end] = np.maximum(scatter, _scatter_of_all(one_sided, resolution))[end]
        away[end] = one_sided[end]
    return away, np.maximum(scatter, least)


def _scatter_of_all(away: Float, resolution: float) -> Float:
    """Return the local scatter at each row, from the rows whose distance is known."""
    known = ~np.isnan(away)
    place = np.cumsum(known) - 1
    return np.asarray(local_scatter(away[known], resolution)[np.maximum(place, 0)])
