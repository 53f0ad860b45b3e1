"""Fits a slow change of unknown form, which has fewer periods in the record than the four that a
line needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record, orthonormal

Float = NDArray[np.float64]

HALF_PERIODS = 8
"""Number of curves cos(πk·t/T), k = 1 to 8; the highest curve has four periods, the smallest number
of periods of a line (a sinusoidal error) that the searches find."""
LEAST_OF_LEFT = 0.5
"""Share of the residual's mean square, after the fit of model, drift, lines and steps, that a slow
change must exceed."""
LEAST_ROWS = 44
"""Fewest degrees of freedom of the residual. In white noise with 44 degrees of freedom, 8 curves
explain more than half with the probability 0.0007 (beta distribution of 4 and 18)."""


@dataclass(frozen=True)
class SlowChange:
    """A rise and fall with fewer than four periods in the record."""

    size_arcsec: float
    """Difference between the highest and the lowest value of the change."""
    length: float
    """Length of the record, on its measured clock."""


def slow_change(record: Record, others: Float) -> SlowChange | None:
    """Fit a slow change; ``others`` are the columns of lines and steps, shape (rows, k).

    The result is None if the change explains at most LEAST_OF_LEFT of the residual's sum of
    squares, or if the record has too few rows.
    """
    if record.clock.size - record.base.shape[1] - others.shape[1] < LEAST_ROWS:
        return None
    when = record.measured - record.measured.min()
    length = float(np.ptp(when))
    waves = np.cos(np.pi * np.outer(when / max(length, 1e-300), np.arange(1, HALF_PERIODS + 1)))
    model = orthonormal([record.base, others]) if others.shape[1] else record.base
    left = record.residual_arcsec - model @ (model.T @ record.residual_arcsec)
    own = orthonormal([model, waves])[:, model.shape[1] :]
    curve = own @ (own.T @ left)
    if float(curve @ curve) <= LEAST_OF_LEFT * float(left @ left):
        return None
    return SlowChange(float(np.ptp(curve)), length)
