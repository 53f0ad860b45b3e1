"""Models a shaft between disc and table top that twists under friction."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.typed_content import NotNegative, Number
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.declaration import STROKE_DEG, Declaration, Given, Occasion, Random, Recipe
from arctrue.table.draws import log_uniform, sign


@dataclass(frozen=True, slots=True)
class ShaftWindUp(Cause):
    """Friction twists the disc relative to the table top by ±``angle_rad``, along a hysteresis
    loop.

    After a reversal the twist changes sign within a stroke, by Dahl's model of dry friction:
    direction × angle × (1 − 2·exp(−travel/stroke)). With a stroke of 0, or if the travel since the
    reversal is unknown, the twist is direction × angle.
    """

    angle_rad: float
    stroke_rad: float = 0.0

    def disc_turn_rad(self, conditions: Conditions) -> NDArray[np.float64]:
        """Return the angle of the disc relative to the table top, shape ``(n,)``."""
        turn = self.angle_rad * conditions.direction
        travel = conditions.since_reversal_rad
        if self.stroke_rad > 0.0 and travel is not None:
            turn = turn * (1.0 - 2.0 * np.exp(-travel / self.stroke_rad))
        return np.asarray(turn)


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    arcsec: Number
    stroke_deg: NotNegative = STROKE_DEG

    def physical(self, lines: int) -> ShaftWindUp:
        """Return the cause that these values describe."""
        return ShaftWindUp(self.arcsec * RAD_PER_ARCSEC, math.radians(self.stroke_deg))


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    angle = sign(random) * size / 2 * RAD_PER_ARCSEC
    return [ShaftWindUp(angle, float(np.deg2rad(log_uniform(0.2, 10.0, random))))]


DECLARATION = Declaration(
    ShaftWindUp,
    values=Values,
    recipes=(
        Recipe(
            name="hysteresis",
            unit="arcsec",
            low=0.2,
            high=5.0,
            draw=draw,
            rank=6,
            coefficients=1,
        ),
    ),
)
