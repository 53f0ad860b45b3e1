"""Models a scratch, dirt or a splice on the graduation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from arctrue.base.typed_content import Number, Positive
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Given, Occasion, Random, Recipe
from arctrue.table.draws import angle, log_uniform, sign
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class GraduationBump(Cause):
    """The lines near one place of the disc are displaced by height·exp(−|distance/width|^power/2).

    Power 2 gives a Gaussian curve whose sigma is the width; a larger power gives a flat top and
    steep edges (dirt, a splice), a smaller power a sharp top (a scratch). ``skew`` makes one side
    wider and the other side narrower: width·(1 ± skew).
    """

    height_rad: float
    place_rad: float
    width_rad: float
    power: float = 2.0
    skew: float = 0.0

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """Return the displacement of the lines, shape ``(n,)``; half a turn away from the place it
        is practically 0."""
        away = np.angle(np.exp(1j * (disc_angle_rad - self.place_rad)))
        width = self.width_rad * (1.0 + self.skew * np.sign(away))
        return np.asarray(self.height_rad * np.exp(-0.5 * np.abs(away / width) ** self.power))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    arcsec: Number
    place_deg: Number
    width_deg: Positive
    power: Positive = 2.0
    skew: Annotated[float, Meta(ge=-0.9, le=0.9)] = 0.0

    def physical(self, lines: int) -> GraduationBump:
        """Return the cause that these values describe."""
        return GraduationBump(
            self.arcsec * RAD_PER_ARCSEC,
            math.radians(self.place_deg),
            math.radians(self.width_deg),
            self.power,
            self.skew,
        )


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    width = float(np.deg2rad(np.exp(random.uniform(np.log(0.1), np.log(2.0)))))
    height, place = sign(random) * size * RAD_PER_ARCSEC, angle(random)
    power, skew = log_uniform(1.2, 6.0, random), float(random.uniform(-0.5, 0.5))
    return [GraduationBump(height, place, width, power, skew)]


DECLARATION = Declaration(
    GraduationBump,
    values=Values,
    recipes=(
        Recipe(
            name="graduation_defect",
            unit="arcsec",
            low=0.5,
            high=5.0,
            draw=draw,
            rank=12,
            coefficients=1,
            places=360 / 0.1,
        ),
    ),
)
