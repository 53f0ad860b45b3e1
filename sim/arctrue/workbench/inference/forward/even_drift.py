"""Finds an even drift that remains with the lines of a record in the model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record, orthonormal
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import best_fit, fit_from, usual_starts

Float = NDArray[np.float64]

LEAST_GAIN = 11.0
"""Smallest gain in log likelihood of a drift over slow noise alone. In 128 logs of 16 kinds of
noise (``sim/tests/workbench/noisy_logs.py``) the largest gain is 10.2, in a random walk. The
uncertainty of the drift does not suffice: in that log the drift is 18 times its uncertainty,
because a random walk looks like faster noise when a drift through its end points is subtracted."""


@dataclass(frozen=True)
class EvenDrift:
    """A change in proportion to time."""

    size_arcsec: float
    """Change over the record."""
    sigma_arcsec: float
    length: float
    """Length of the record, on its measured clock."""


def even_drift(record: Record, lines: Float, noise: KernelNoise) -> EvenDrift | None:
    """Return the even drift of a record whose base consists of constants and this drift only; None
    if it is not significant.

    Orders of the table over a part of a turn look like a drift: with orders in the model, the
    search for effects decides.
    """
    number = np.unique(record.stretch)
    if record.base.shape[1] != number.size + 1:
        return None
    length = float(np.ptp(record.measured))
    ramp = (record.measured - record.measured.mean()) / max(length, 1e-300)
    constants = (record.stretch[:, np.newaxis] == number).astype(np.float64)
    others = orthonormal([constants, lines]) if lines.shape[1] else constants
    rows = record.rows()
    plain = replace(rows, values=np.column_stack([record.residual_arcsec, others]))
    both = replace(rows, values=np.column_stack([record.residual_arcsec, ramp, others]))
    grown = fit_from(both, noise)
    whitened = rows.factor(grown.noise).whiten(both.values)
    columns = whitened[:, 1:]
    inverse = np.linalg.pinv(columns.T @ columns)
    size = float((inverse @ (columns.T @ whitened[:, 0]))[0])
    sigma = float(np.sqrt(inverse[0, 0]))
    if size**2 <= 2.0 * LEAST_GAIN * sigma**2:
        return None
    rival = best_fit(plain, [noise, *usual_starts(plain)])
    gain = record.of_few_rows(grown.score - rival.score)
    return EvenDrift(size, sigma, length) if gain > LEAST_GAIN else None
