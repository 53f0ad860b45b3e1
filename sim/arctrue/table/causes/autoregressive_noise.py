"""Models noise of the readings that depends on the previous row: first-order autoregressive noise,
AR(1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.declaration import Declaration, Occasion, Random, Recipe
from arctrue.table.noise import Noise


@dataclass(frozen=True, slots=True)
class AutoregressiveNoise(Cause):
    """The noise x_i = correlation·x_{i−1} + w_i depends on the previous row, not on the elapsed
    time; each run begins independently."""

    sigma_rad: float
    correlation: float
    """Correlation of neighbouring rows, above −1 and below 1."""

    def head_noise(self, head: int, conditions: Conditions) -> Noise:
        """Return one Gauss–Markov process with the standard deviation ``sigma_rad``."""
        same_run = np.concatenate([[False], np.diff(conditions.run) == 0])
        decay = np.where(same_run, self.correlation, 0.0)[None, :]
        return Noise(np.zeros(same_run.size), np.array([self.sigma_rad]), decay)


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [AutoregressiveNoise(size * RAD_PER_ARCSEC, float(random.uniform(0.5, 0.98)))]


DECLARATION = Declaration(
    AutoregressiveNoise,
    recipes=(
        Recipe(
            name="autoregressive",
            unit="arcsec",
            low=0.03,
            high=0.3,
            draw=draw,
            rank=34,
            kind="noise",
        ),
    ),
)
