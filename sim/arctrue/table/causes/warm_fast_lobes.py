"""Models a disc that changes its shape when it is warm and turns fast."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.typed_content import Number
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.conditions import heating_k
from arctrue.table.declaration import Declaration, Given, Occasion, Order, Random, Recipe
from arctrue.table.draws import angle
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class WarmFastLobes(Cause):
    """The warm adhesive yields to the centrifugal force; the lines shift in proportion to
    temperature rise × speed²."""

    order: int
    rate_rad_s2_per_k: float
    phase_rad: float

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """Return the error of the lines, shape ``(n,)``."""
        wave = np.cos(self.order * disc_angle_rad + self.phase_rad)
        load = heating_k(state) * state.speed_rad_s**2
        return np.asarray(self.rate_rad_s2_per_k * load * wave)


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    order: Order
    arcsec_s2_per_k: Number
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> WarmFastLobes:
        """Return the cause that these values describe."""
        rate = self.arcsec_s2_per_k * RAD_PER_ARCSEC
        return WarmFastLobes(self.order, rate, math.radians(self.phase_deg))


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [WarmFastLobes(int(random.integers(2, 6)), size * RAD_PER_ARCSEC, angle(random))]


DECLARATION = Declaration(
    WarmFastLobes,
    values=Values,
    recipes=(
        Recipe(
            name="warm_fast_lobes",
            unit="arcsec/K/(rad/s)^2",
            low=0.1,
            high=1.0,
            draw=draw,
            rank=24,
            kind="stranger",
            coefficients=2,
            places=4,
        ),
    ),
)
