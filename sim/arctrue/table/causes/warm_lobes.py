"""Models a disc that changes its shape when it is warm."""

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
class WarmLobes(Cause):
    """The lines shift by an angle with ``order`` periods a turn, in proportion to the temperature
    rise (order 2: an oval disc)."""

    order: int
    rate_rad_per_k: float
    phase_rad: float

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """Return the error of the lines, shape ``(n,)``."""
        wave = np.cos(self.order * disc_angle_rad + self.phase_rad)
        return np.asarray(self.rate_rad_per_k * heating_k(state) * wave)


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    order: Order
    arcsec_per_k: Number
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> WarmLobes:
        """Return the cause that these values describe."""
        rate = self.arcsec_per_k * RAD_PER_ARCSEC
        return WarmLobes(self.order, rate, math.radians(self.phase_deg))


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [WarmLobes(2, size * RAD_PER_ARCSEC, angle(random))]


DECLARATION = Declaration(
    WarmLobes,
    values=Values,
    recipes=(
        Recipe(
            name="warm_ovality",
            unit="arcsec/K",
            low=0.1,
            high=0.5,
            draw=draw,
            rank=18,
            kind="parts",
            parts=("temperature", "order:2", "disc"),
            coefficients=2,
        ),
    ),
)
