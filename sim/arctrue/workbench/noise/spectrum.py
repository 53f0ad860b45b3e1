"""Stationary noise: a white part and exponentially correlated parts.

The covariance of two rows a time τ apart is Σ aⱼ·exp(−|τ|/τⱼ), and the white variance where τ = 0.
A sum of parts with time constants a few octaves apart approximates any falling spectrum: flicker
noise, an Ornstein–Uhlenbeck process, a first-order autoregression.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

BLOCK = 1 << 13
"""Frequencies whose densities stay in the cache of the processor while parts are added."""


@dataclass(frozen=True)
class Spectrum:
    """White variance, and variance and time constant of each coloured part."""

    white: float
    """Variance of a row, arcsec²."""
    constants: Float = field(default_factory=lambda: np.zeros(0))
    """τⱼ in the unit of the rows' clock: seconds, or rows where there is no time."""
    variances: Float = field(default_factory=lambda: np.zeros(0))
    """aⱼ, arcsec²."""

    @property
    def variance(self) -> float:
        """Variance of a row, all parts together."""
        return float(self.white + self.variances.sum())

    @property
    def coloured_arcsec(self) -> float:
        """Standard deviation of the coloured parts together."""
        return float(np.sqrt(self.variances.sum()))

    def equals(self, other: Spectrum) -> bool:
        """Tell whether both have the same parts."""
        return self is other or (
            self.white == other.white
            and np.array_equal(self.constants, other.constants)
            and np.array_equal(self.variances, other.variances)
        )

    def times(self, factor: float) -> Spectrum:
        """Return the same spectrum with all variances multiplied by a factor."""
        return Spectrum(self.white * factor, self.constants, self.variances * factor)

    def density(self, frequency: Float, step: float) -> Float:
        """Return the mean |Σ eᵢ·exp(−2πj·f·tᵢ)|² per row, for rows ``step`` apart, arcsec².

        White noise has its variance at every frequency. ``frequency`` is in periods per unit of the
        clock; the sum over rows is that of the infinite series.
        """
        flat = np.ravel(np.asarray(frequency, dtype=np.float64))
        found = np.full(flat.size, self.white)
        for start in range(0, flat.size, BLOCK):
            block = slice(start, start + BLOCK)
            # 1 − 2ρ·cos 2x + ρ² = (1 − ρ)² + 4ρ·sin² x keeps its digits where x and 1 − ρ are
            # small.
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

    Neighbouring ones have a ratio of 8 or less; there are seven at most.
    """
    shortest = 2.0 * step
    if step <= 0.0 or span <= 2.0 * shortest:
        return np.zeros(0)
    count = int(np.clip(np.ceil(np.log(span / shortest) / np.log(LARGEST_RATIO)) + 1, 2, 7))
    return np.asarray(np.geomspace(shortest, span, count))


LARGEST_RATIO = 8.0
"""Largest ratio of neighbouring time constants: such a sum follows a 1/f spectrum to 9 %."""
