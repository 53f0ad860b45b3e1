"""Describes stationary noise by a white part and exponentially correlated parts.

The covariance of two rows a time τ apart is Σ aⱼ·exp(−|τ|/τⱼ); for τ = 0 the white variance is
added. A sum of parts with time constants a few octaves apart approximates any falling spectrum:
flicker noise, an Ornstein–Uhlenbeck process, a first-order autoregression.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

NEGLIGIBLE = 0.01
"""Largest change of the mean log likelihood of a stretch of rows by the parts that are left out.
The standard uncertainty of a coefficient changes by at most a tenth."""
BLOCK = 1 << 13
"""Number of frequencies in a block, whose densities stay in the processor's cache while parts are
added."""


@dataclass(frozen=True)
class Spectrum:
    """Variance of the white part, and variance and time constant of each coloured part."""

    white: float
    """White variance of a row, arcsec²."""
    constants: Float = field(default_factory=lambda: np.zeros(0))
    """Time constants τⱼ in the unit of the rows' clock: seconds, or rows if there is no time."""
    variances: Float = field(default_factory=lambda: np.zeros(0))
    """Variances aⱼ of the coloured parts, arcsec²."""

    @property
    def variance(self) -> float:
        """Variance of a row, the sum over all parts."""
        return float(self.white + self.variances.sum())

    def equals(self, other: Spectrum) -> bool:
        """Tell whether both spectra have the same parts."""
        return self is other or (
            self.white == other.white
            and np.array_equal(self.constants, other.constants)
            and np.array_equal(self.variances, other.variances)
        )

    def times(self, factor: float) -> Spectrum:
        """Return the same spectrum with all variances multiplied by a factor."""
        return Spectrum(self.white * factor, self.constants, self.variances * factor)

    def without_negligible_parts(self, rows: int, step: float) -> Spectrum:
        """Return the spectrum without the parts that hardly change the likelihood of a number of
        rows that are at least ``step`` apart.

        The variance of the left-out parts becomes white. The mean log likelihood of the rows then
        changes by about ‖D‖²/(4·white²) or less, where D is the sum of the left-out covariances
        between different rows and ‖D‖ its Frobenius norm; NEGLIGIBLE limits this value.
        """
        if step <= 0.0 or not self.variances.any():
            return self
        # Σ exp(−2·k·step/τ) over the lags k ≠ 0 is coth(step/τ) − 1.
        lags = 2.0 / np.expm1(2.0 * step / self.constants)
        norms = self.variances * np.sqrt(rows * lags)
        order = np.argsort(norms)
        left_out = order[np.cumsum(norms[order]) <= 2.0 * np.sqrt(NEGLIGIBLE) * self.white]
        kept = np.delete(np.arange(self.variances.size), left_out)
        white = self.white + float(self.variances[left_out].sum())
        return Spectrum(white, self.constants[kept], self.variances[kept])

    def density(self, frequency: Float, step: float) -> Float:
        """Return the mean |Σ eᵢ·exp(−2πj·f·tᵢ)|² per row, for rows ``step`` apart, arcsec².

        eᵢ is the noise of row i, tᵢ its time; the series of rows is infinite. The density of white
        noise is its variance at every frequency. ``frequency`` is in periods per unit of the clock.
        """
        flat = np.ravel(np.asarray(frequency, dtype=np.float64))
        found = np.full(flat.size, self.white)
        for start in range(0, flat.size, BLOCK):
            block = slice(start, start + BLOCK)
            # 1 − 2ρ·cos 2x + ρ² = (1 − ρ)² + 4ρ·sin² x loses no digits if x and 1 − ρ are small.
            squared = np.sin(flat[block] * (np.pi * step)) ** 2
            for constant, variance in zip(self.constants, self.variances, strict=True):
                rho, away = np.exp(-step / constant), -np.expm1(-step / constant)
                of_part = squared * (4.0 * rho)
                of_part += away**2
                np.divide(variance * away * (1.0 + rho), of_part, out=of_part)
                found[block] += of_part
        return found.reshape(np.shape(frequency))


def time_constants(step: float, span: float) -> Float:
    """Return τⱼ from twice the step of the rows to their whole span, in even logarithmic steps.

    Neighbouring time constants have a ratio of at most 8, or a larger ratio if more than seven time
    constants would be needed. A span of at most four steps has none.
    """
    shortest = 2.0 * step
    if step <= 0.0 or span <= 2.0 * shortest:
        return np.zeros(0)
    count = int(np.clip(np.ceil(np.log(span / shortest) / np.log(LARGEST_RATIO)) + 1, 2, 7))
    return np.asarray(np.geomspace(shortest, span, count))


LARGEST_RATIO = 8.0
"""Largest ratio of neighbouring time constants; a sum with this ratio follows a 1/f spectrum to 4
%."""
