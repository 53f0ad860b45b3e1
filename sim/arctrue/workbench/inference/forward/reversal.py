"""Fits the difference of a reference's readings between directions of approach, with steps in time.

If effects were fitted one at a time to a record of several passes, the fit of a drift would absorb
a jump or a slow change and hide the reversal error. This module therefore fits the direction of
approach together with steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from arctrue.workbench.inference.forward.record import Record, orthonormal
from arctrue.workbench.inference.forward.tests_of_a_line import FAMILY_WISE

Float = NDArray[np.float64]

LEAST_PASSES = 4
"""Smallest number of passes, two in each direction: at a single reversal, a change in time looks
the same as the direction."""
LEAST_OWN = 1e-6
"""The reversal error is fitted only if the model leaves a larger share than this of the direction
column's sum of squares; with a smaller share, the model already contains a reversal error."""

MOST_P = 0.1 * FAMILY_WISE
"""Largest p of a reversal error. It is a tenth of the family-wise level, because this test is
applied to every record with both directions, in addition to the other searches."""


@dataclass(frozen=True)
class Reversal:
    """The difference of the readings between the directions of approach."""

    size_arcsec: float
    """Mean of the upward readings minus mean of the downward readings."""
    sigma_arcsec: float
    passes: int


def reversal_of(record: Record, direction: Float, steps: Float) -> Reversal | None:
    """Fit ``direction`` (±1, shape (rows,)) together with the record's base and ``steps``, shape
    (rows, k).

    The size comes from ordinary least squares over all rows: if the weights followed slow noise,
    only the rows next to each reversal would count. The uncertainty comes from the scatter of fits
    that omit one pass each (jackknife). The result is None if there are too few passes, if the base
    contains the direction, or if noise alone may cause a difference of this size.
    """
    number = np.concatenate([[0], np.cumsum(np.diff(direction) != 0.0)])
    passes = int(number[-1]) + 1
    if passes < LEAST_PASSES:
        return None
    others = orthonormal([record.base, steps])
    own = direction - others @ (others.T @ direction)
    if float(own @ own) <= LEAST_OWN * direction.size:
        return None
    columns = np.column_stack([direction, others])
    left_out = np.array([
        _size(record.residual_arcsec, columns, number != one) for one in range(passes)
    ])  # fmt: skip
    size = _size(record.residual_arcsec, columns, number >= 0)
    scatter = float(np.sum((left_out - left_out.mean()) ** 2))
    sigma = float(np.sqrt(scatter * (passes - 1) / passes))
    free = passes - 1 - steps.shape[1]
    if free < 1 or 2.0 * float(student.sf(abs(size) / sigma, free)) >= MOST_P:
        return None
    return Reversal(size, sigma, passes)


def _size(measured: Float, columns: Float, kept: NDArray[np.bool_]) -> float:
    """Return twice the coefficient of the first column, fitted to the rows in ``kept``."""
    found = np.linalg.lstsq(columns[kept], measured[kept], rcond=1e-9)[0]
    return 2.0 * float(found[0])
