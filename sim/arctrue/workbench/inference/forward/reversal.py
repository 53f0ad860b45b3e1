"""Fits the difference of a reference's readings between directions of approach, with steps in time.

If effects were fitted one at a time to a record of several passes, the fit of a drift would absorb
a jump or a slow change and hide the reversal error. This module therefore fits the direction of
approach together with steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record, orthonormal
from arctrue.workbench.inference.forward.tests_of_a_line import FAMILY_WISE
from arctrue.workbench.numeric.distributions import student_upper_p

Float = NDArray[np.float64]

LEAST_PASSES = 4
"""Smallest number of passes that confirm a reversal error, two in each direction: at a single
reversal, a change in time looks the same as the direction."""
MOST_OF_THE_RECORD = 0.75
"""Smallest share of the mean square of the residual that the direction must remove in two or three
passes. Base and steps are projected out; the values are means over parts of the passes. With an
even drift in the base, none of 4,000 random walks over two passes reaches this share, and 0.3 % of
those over three passes do."""
PARTS_OF_A_PASS = 24
"""Number of parts of a pass whose means are compared. The means contain little of the noise of
single rows, which cannot look like a reversal error; they contain all of a random walk, which
can."""
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
    sigma_arcsec: float | None
    """Standard uncertainty; None if too few passes confirm the size, so that a change in time may
    look the same."""
    passes: int

    @property
    def confirmed(self) -> bool:
        """True if four or more passes show the same difference."""
        return self.sigma_arcsec is not None


def reversal_of(record: Record, direction: Float, steps: Float) -> Reversal | None:
    """Fit ``direction`` (±1, shape (rows,)) together with the record's base and ``steps``, shape
    (rows, k).

    The size comes from ordinary least squares over all rows: if the weights followed slow noise,
    only the rows next to each reversal would count. The uncertainty comes from the scatter of fits
    that omit one pass each (jackknife), and is at least that of the rows, because a few differences
    may come out alike by chance. The result is None if there are too few passes, if the base
    contains the direction, or if noise alone may cause a difference of this size. With two or three
    passes the difference must have most of the record's mean square, and it has no uncertainty.
    """
    number = np.concatenate([[0], np.cumsum(np.diff(direction) != 0.0)])
    passes = int(number[-1]) + 1
    if passes < 2:
        return None
    others = orthonormal([record.base, steps])
    own = direction - others @ (others.T @ direction)
    if float(own @ own) <= LEAST_OWN * direction.size:
        return None
    if passes < LEAST_PASSES:
        return _of_few_passes(record, direction, others, passes)
    columns = np.column_stack([direction, others])
    left_out = np.array([
        _size(record.residual_arcsec, columns, number != one) for one in range(passes)
    ])  # fmt: skip
    size = _size(record.residual_arcsec, columns, number >= 0)
    scatter = float(np.sum((left_out - left_out.mean()) ** 2))
    sigma = float(np.sqrt(scatter * (passes - 1) / passes))
    sigma = max(sigma, _sigma_of_rows(record.residual_arcsec, own, columns, direction))
    free = passes - 1 - steps.shape[1]
    if sigma <= 0.0 or free < 1 or 2.0 * student_upper_p(abs(size) / sigma, free) >= MOST_P:
        return None
    return Reversal(size, sigma, passes)


def _of_few_passes(record: Record, direction: Float, others: Float, passes: int) -> Reversal | None:
    """Return the difference without an uncertainty if it has most of the mean square of the means
    over parts of the passes."""
    own = _means(direction - others @ (others.T @ direction), direction)
    left = _means(record.residual_arcsec - others @ (others.T @ record.residual_arcsec), direction)
    removed = float(own @ left) ** 2 / float(own @ own)
    if removed < MOST_OF_THE_RECORD * float(left @ left):
        return None
    columns = np.column_stack([direction, others])
    return Reversal(_size(record.residual_arcsec, columns, direction != 0.0), None, passes)


def _sigma_of_rows(measured: Float, own: Float, columns: Float, direction: Float) -> float:
    """Return the standard uncertainty of the size from the scatter of the rows.

    ``own``: direction with the other columns projected out. The sums of own·residual over parts of
    the passes count as independent, so that noise that is shorter than a part may be correlated.
    """
    left = measured - columns @ np.linalg.lstsq(columns, measured, rcond=1e-9)[0]
    free = max(measured.size - columns.shape[1], 1) / measured.size
    sums = np.array([part.sum() for part in _parts(own * left, direction)])
    return float(2.0 * np.sqrt(np.sum(sums**2) / free) / (own @ own))


def _means(values: Float, direction: Float) -> Float:
    """Return the mean of the values over each of PARTS_OF_A_PASS parts of every pass."""
    return np.array([part.mean() for part in _parts(values, direction)])


def _parts(values: Float, direction: Float) -> list[Float]:
    passes = np.split(values, np.flatnonzero(np.diff(direction) != 0.0) + 1)
    return [part for one in passes for part in np.array_split(one, PARTS_OF_A_PASS) if part.size]


def _size(measured: Float, columns: Float, kept: NDArray[np.bool_]) -> float:
    """Return twice the coefficient of the first column, fitted to the rows in ``kept``."""
    found = np.linalg.lstsq(columns[kept], measured[kept], rcond=1e-9)[0]
    return 2.0 * float(found[0])
