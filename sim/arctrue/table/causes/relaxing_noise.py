"""Models noise of the readings with exponential correlation: an Ornstein–Uhlenbeck process."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.declaration import Declaration, Occasion, Random, Recipe
from arctrue.table.draws import log_uniform
from arctrue.table.noise import Noise


@dataclass(frozen=True, slots=True)
class RelaxingNoise(Cause):
    """Air or a correcting servo causes noise with the covariance sigma²·exp(−|Δt|/time constant).

    The noise is independent for each head. The process continues between runs.
    """

    sigma_rad: float
    constant_s: float

    def head_noise(self, head: int, conditions: Conditions) -> Noise:
        """Return one Ornstein–Uhlenbeck process."""
        return Noise.relaxing(
            np.array([self.sigma_rad]), np.array([self.constant_s]), conditions.time_s
        )


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    constant_s = log_uniform(0.05, 30.0, random)
    return [RelaxingNoise(size * RAD_PER_ARCSEC, constant_s)]


DECLARATION = Declaration(
    RelaxingNoise,
    recipes=(
        Recipe(
            name="ornstein_uhlenbeck",
            unit="arcsec",
            low=0.03,
            high=0.3,
            draw=draw,
            rank=33,
            kind="noise",
        ),
    ),
)
