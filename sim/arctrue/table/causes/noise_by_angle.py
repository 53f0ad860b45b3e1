"""Models noise of the readings that is stronger on one side of the disc."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.declaration import Declaration, Occasion, Random, Recipe
from arctrue.table.draws import angle
from arctrue.table.noise import Noise
from arctrue.table.rotary_table import HEADS


@dataclass(frozen=True, slots=True)
class NoiseByAngle(Cause):
    """White noise of each head has a variance that depends on the disc angle, because of dirt or a
    varying distance.

    The variance is ``sigma_rad²·(1 + contrast·cos(order·(θ − β) + phase))`` with a contrast of 0 to
    1.
    """

    heads_rad: tuple[float, float]
    """Stator angle β of each head."""
    sigma_rad: float
    order: int
    contrast: float
    phase_rad: float

    def head_noise(self, head: int, conditions: Conditions) -> Noise:
        """Return noise with an individual standard deviation for each row.

        Raises ValueError for a head without an angle in ``heads_rad``.
        """
        if head >= len(self.heads_rad):
            raise ValueError(
                f"noise by angle is given for {len(self.heads_rad)} heads, "
                f"asked for head {head + 1}"
            )
        disc_rad = conditions.angle_rad - self.heads_rad[head]
        share = 1.0 + self.contrast * np.cos(self.order * disc_rad + self.phase_rad)
        return Noise.white(self.sigma_rad * np.sqrt(np.maximum(share, 0.0)), disc_rad.size)


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    angles = (HEADS[0].angle_rad, HEADS[1].angle_rad)
    order, contrast = int(random.integers(1, 4)), float(random.uniform(0.6, 1.0))
    return [NoiseByAngle(angles, size * RAD_PER_ARCSEC, order, contrast, angle(random))]


DECLARATION = Declaration(
    NoiseByAngle,
    recipes=(
        Recipe(
            name="by_angle",
            unit="arcsec",
            low=0.05,
            high=0.3,
            draw=draw,
            rank=30,
            kind="noise",
        ),
    ),
)
