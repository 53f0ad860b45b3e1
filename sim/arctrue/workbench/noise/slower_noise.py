"""Extrapolates the noise of a capture to noise that is slower than the capture's runs.

Each run has an offset of its own, so its rows do not show noise much slower than the run. Such
noise continues over the pauses, and successive runs then have nearly equal offsets. Its level
follows from the noise within the runs if the spectrum continues as a power law.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.noise.noise import FittedGroup, Noise
from arctrue.workbench.noise.spectrum import LARGEST_RATIO, Spectrum

Float = NDArray[np.float64]

FASTER_PARTS = 6
"""Number of parts with time constants below the longest run that count in the level at the run's
length. The next part would add less than 8⁻⁶ to the level, if the exponent is 1 or more."""
LONGEST_SPANS = 2.0
"""Longest time constant, in lengths of the whole capture. Noise with this constant keeps e^(−½) =
61 % of its correlation from the first to the last row. Slower noise is a constant of the set, as a
wrong angle between the heads is."""


@dataclass(frozen=True)
class SlowerNoise:
    """Noise slower than the longest run, up to a longest time constant."""

    length_s: float
    """Length of the longest run."""
    longest_s: float
    """Longest time constant."""
    density: float
    """Two-sided density of the slow noise at one period in the longest run, arcsec²·s."""
    deviation: float
    """Standard deviation of the logarithm of the density."""

    @property
    def _count(self) -> int:
        return int(np.ceil(np.log(self.longest_s / self.length_s) / np.log(LARGEST_RATIO) - 1e-9))

    @property
    def _step(self) -> float:
        """Ratio of neighbouring time constants."""
        return float((self.longest_s / self.length_s) ** (1.0 / self._count))

    @property
    def constants_s(self) -> Float:
        """Time constants of the parts, seconds."""
        return self._constants(0)

    def _constants(self, first: int) -> Float:
        powers = np.arange(first, self._count, dtype=np.float64) + 0.5
        return np.asarray(self.length_s * self._step**powers, dtype=np.float64)

    def variances(self, exponent: float) -> Float:
        """Return the variance of each part, arcsec², if the density falls as 1/f^exponent."""
        constants = self._constants(-FASTER_PARTS)
        shares: Float = (constants / self.length_s) ** (exponent - 1.0)
        found = _densities(Spectrum(0.0, constants, shares), 1.0 / self.length_s)
        return np.asarray(shares[FASTER_PARTS:] * (self.density / found.sum()))


def slower_noise(noise: Noise, span_s: float) -> SlowerNoise | None:
    """Return the noise that is slower than the capture's runs; ``span_s`` is the time from the
    first to the last row of the capture.

    The result is None if the longest run is the whole capture, and if the runs show no slow noise:
    at one period in the longest run, its density, divided by e to the power of the standard
    deviation of its logarithm, is then below that of the white part.
    """
    groups = [
        group
        for group in noise.groups
        if group.channel == "capture" and group.fit.spectrum.constants.size
    ]
    if not groups:
        return None
    group = max(groups, key=lambda item: (float(item.fit.spectrum.constants[-1]), item.rows))
    spectrum = group.fit.spectrum
    length = float(spectrum.constants[-1])
    densities = _densities(spectrum, 1.0 / length)
    density = float(densities.sum())
    white = spectrum.white * _row_step(group)
    if span_s <= length or density <= white:
        return None
    shares = densities / density
    deviation = float(np.sqrt(shares @ group.fit.covariance[1:, 1:] @ shares))
    if density * np.exp(-deviation) <= white:
        return None
    return SlowerNoise(length, LONGEST_SPANS * span_s, density, deviation)


def _row_step(group: FittedGroup) -> float:
    """Return the clock step of the group's rows: half of the shortest time constant
    (:func:`time_constants`)."""
    return 0.5 * float(group.fit.spectrum.constants[0])


def _densities(spectrum: Spectrum, frequency: float) -> Float:
    """Return the two-sided density of each part at a frequency, arcsec² times the clock's unit."""
    turning = 2.0 * np.pi * frequency * spectrum.constants
    return np.asarray(2.0 * spectrum.variances * spectrum.constants / (1.0 + turning**2))


def correlation_of_means(first_s: Float, last_s: Float, constant_s: float) -> Float:
    """Return the covariance of the means over runs of noise with the covariance exp(−τ/constant).

    ``first_s``, ``last_s``: times of the first and last row of each run, (runs,). Runs before a run
    at which the clock goes back are not correlated with the runs after it.
    """
    length = np.maximum((last_s - first_s) / constant_s, 1e-6)
    mean = -np.expm1(-length) / length
    gap = (first_s[np.newaxis, :] - last_s[:, np.newaxis]) / constant_s
    found = np.triu(np.outer(mean, mean) * np.exp(-np.maximum(gap, 0.0)), 1)
    session = np.cumsum(np.concatenate([[False], first_s[1:] < last_s[:-1]]))
    found[session[:, np.newaxis] != session] = 0.0
    found += found.T
    found[np.diag_indices(length.size)] = 2.0 * (length + np.expm1(-length)) / length**2
    return np.asarray(found)
