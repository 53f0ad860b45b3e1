"""Models a reference instrument that drifts back and forth during the measurement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause, Stations
from arctrue.table.declaration import Declaration, Occasion, Random, Recipe
from arctrue.table.draws import log_uniform
from arctrue.table.noise import Noise


@dataclass(frozen=True, slots=True)
class WanderingReference(Cause):
    """Air and temperature move the stand: an Ornstein–Uhlenbeck process with a time constant of
    minutes."""

    sigma_rad: float
    constant_s: float

    def instrument_noise(self, stations: Stations) -> Noise:
        """Return one Ornstein–Uhlenbeck process over the stations."""
        return Noise.relaxing(
            np.array([self.sigma_rad]), np.array([self.constant_s]), stations.conditions.time_s
        )


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    constant_s = log_uniform(30.0, 1200.0, random)
    return [WanderingReference(size * RAD_PER_ARCSEC, constant_s)]


DECLARATION = Declaration(
    WanderingReference,
    recipes=(
        Recipe(
            name="wandering_reference",
            unit="arcsec",
            low=0.05,
            high=0.5,
            draw=draw,
            rank=38,
            kind="noise",
        ),
    ),
)
