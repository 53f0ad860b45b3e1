"""Noise of the readings that forgets itself exponentially: Ornstein–Uhlenbeck."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.noise import Noise


@dataclass(frozen=True, slots=True)
class RelaxingNoise(Cause):
    """Air, or a servo that corrects: covariance sigma²·exp(−|Δt|/time constant), each head its own.

    The process goes on between runs.
    """

    sigma_rad: float
    constant_s: float

    def head_noise(self, head: int, conditions: Conditions) -> Noise:
        """One process."""
        return Noise.relaxing(
            np.array([self.sigma_rad]), np.array([self.constant_s]), conditions.time_s
        )
