"""Models noise of the readings whose spectrum falls with a power of the frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.declaration import Declaration, Occasion, Random, Recipe
from arctrue.table.noise import Noise

A_DECADE = 2
"""Number of processes per decade of τ: at exponent 1 the spectrum of their sum then ripples by less
than 0.1 dB."""


@dataclass(frozen=True, slots=True)
class PowerLawNoise(Cause):
    """Each head has independent noise with a power spectral density ∝ f^−exponent, 0 < exponent < 2
    (1: pink noise).

    The noise is the sum of Ornstein–Uhlenbeck processes. Their time constants τ have equal ratios
    and their variances are ∝ τ^(exponent − 1). The spectrum of each process is a Lorentzian ∝
    variance·τ/(1 + (2πfτ)²), and the sum of the spectra over ln τ is ∝ f^−exponent. Below
    1/(2π·longest) the spectrum is flat, so the variance is finite; ``sigma_rad`` is the standard
    deviation of the whole noise.
    """

    sigma_rad: float
    exponent: float = 1.0
    shortest_s: float = 1e-4
    longest_s: float = 300.0

    def __post_init__(self) -> None:
        """Raise ValueError for an exponent for which the noise is not stationary."""
        if not 0 < self.exponent < 2:
            raise ValueError(f"the exponent of the spectrum lies in 0 … 2, found {self.exponent}")

    def head_noise(self, head: int, conditions: Conditions) -> Noise:
        """Return the sum of the processes for these rows."""
        number = 1 + int(np.ceil(A_DECADE * np.log10(self.longest_s / self.shortest_s)))
        constants_s = np.geomspace(self.shortest_s, self.longest_s, number)
        shares = constants_s ** (self.exponent - 1.0)
        sigma = self.sigma_rad * np.sqrt(shares / shares.sum())
        return Noise.relaxing(sigma, constants_s, conditions.time_s)


def draw_pink(size: float, _: Random, __: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [PowerLawNoise(size * RAD_PER_ARCSEC)]


def draw_power_law(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [PowerLawNoise(size * RAD_PER_ARCSEC, float(random.uniform(0.5, 1.8)))]


DECLARATION = Declaration(
    PowerLawNoise,
    recipes=(
        Recipe(
            name="pink",
            unit="arcsec",
            low=0.03,
            high=0.3,
            draw=draw_pink,
            rank=31,
            kind="noise",
        ),
        Recipe(
            name="power_law",
            unit="arcsec",
            low=0.03,
            high=0.3,
            draw=draw_power_law,
            rank=32,
            kind="noise",
        ),
    ),
)
