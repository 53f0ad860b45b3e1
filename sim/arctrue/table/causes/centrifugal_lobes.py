"""Models a disc that the centrifugal force stretches unevenly."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.typed_content import Number
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Given, Occasion, Order, Random, Recipe
from arctrue.table.draws import angle
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class CentrifugalLobes(Cause):
    """The lines shift by an angle with ``order`` periods a turn, in proportion to the speed
    squared."""

    order: int
    stretch_rad_s2: float
    phase_rad: float

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """Return the error of the lines, shape ``(n,)``."""
        wave = np.cos(self.order * disc_angle_rad + self.phase_rad)
        return np.asarray(self.stretch_rad_s2 * state.speed_rad_s**2 * wave)


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    order: Order
    arcsec_s2: Number
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> CentrifugalLobes:
        """Return the cause that these values describe."""
        rate = self.arcsec_s2 * RAD_PER_ARCSEC
        return CentrifugalLobes(self.order, rate, math.radians(self.phase_deg))


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [CentrifugalLobes(3, size * RAD_PER_ARCSEC, angle(random))]


DECLARATION = Declaration(
    CentrifugalLobes,
    values=Values,
    recipes=(
        Recipe(
            name="centrifugal_lobes",
            unit="arcsec/(rad/s)^2",
            low=0.1,
            high=0.5,
            draw=draw,
            rank=19,
            kind="parts",
            parts=("speed^2", "order:3", "disc"),
            coefficients=2,
        ),
    ),
)
