"""A slow change of unknown form: fewer than four periods in the record, and no line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record, orthonormal

Float = NDArray[np.float64]

HALF_PERIODS = 8
"""Curves cos(πk·t/T), k = 1 to 8: up to the four periods from which on a line is looked for."""
LEAST_OF_LEFT = 0.5
"""Of the mean square that model, drift, lines and steps leave: with more, the slow change is most
of it."""
LEAST_ROWS = 44
"""Free rows of white noise, of which 8 curves take more than half with the probability 0.0007 (beta
distribution of 4 and 18)."""


@dataclass(frozen=True)
class SlowChange:
    """What goes up and down in fewer than four periods."""

    size_arcsec: float
    """From its lowest to its highest."""
    length: float
    """Of the record, on its clock."""


def slow_change(record: Record, others: Float) -> SlowChange | None:
    """Beside columns of lines and steps, shape (rows, k); None where it is not most of the rest."""
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
