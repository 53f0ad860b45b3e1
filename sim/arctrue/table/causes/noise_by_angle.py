"""Noise of the readings that is stronger at one side of the disc."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.noise import Noise


@dataclass(frozen=True, slots=True)
class NoiseByAngle(Cause):
    """White noise of each head whose variance follows the disc: dirt, or a distance that changes.

    Variance ``sigma_rad²·(1 + contrast·cos(order·(θ − β) + phase))``, contrast 0 to 1.
    """

    heads_rad: tuple[float, float]
    """Stator angle β of each head."""
    sigma_rad: float
    order: int
    contrast: float
    phase_rad: float

    def head_noise(self, head: int, conditions: Conditions) -> Noise:
        """A standard deviation for each row."""
        disc_rad = conditions.angle_rad - self.heads_rad[head]
        share = 1.0 + self.contrast * np.cos(self.order * disc_rad + self.phase_rad)
        return Noise.white(self.sigma_rad * np.sqrt(np.maximum(share, 0.0)), disc_rad.size)
