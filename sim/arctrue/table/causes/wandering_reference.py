"""A reference instrument that wanders to and fro while it is read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.cause import Cause, Stations
from arctrue.table.noise import Noise


@dataclass(frozen=True, slots=True)
class WanderingReference(Cause):
    """The stand moves with air and temperature: an Ornstein–Uhlenbeck process of some minutes."""

    sigma_rad: float
    constant_s: float

    def instrument_noise(self, stations: Stations) -> Noise:
        """One process over the stations."""
        return Noise.relaxing(
            np.array([self.sigma_rad]), np.array([self.constant_s]), stations.conditions.time_s
        )
