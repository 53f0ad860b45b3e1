"""Models a disc whose centre moves with the temperature."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number
from arctrue.table.cause import Cause, Points
from arctrue.table.conditions import heating_k
from arctrue.table.declaration import MICROMETRE_M, Declaration, Given, Occasion, Random, Recipe
from arctrue.table.draws import vector
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class ThermalCentre(Cause):
    """The hub expands to one side and thereby moves the disc by ``rate_m_per_k`` (x + jy, table
    frame)."""

    rate_m_per_k: complex

    def disc_shift_m(self, state: TableState) -> Points:
        """Return the displacement in the frame of the turning table, metres, shape ``(n,)``."""
        return np.asarray(self.rate_m_per_k * heating_k(state))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    um_per_k: Number
    direction_deg: Number = 0.0

    def physical(self, lines: int) -> ThermalCentre:
        """Return the cause that these values describe."""
        direction_rad = math.radians(self.direction_deg)
        return ThermalCentre(cmath.rect(self.um_per_k * MICROMETRE_M, direction_rad))


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [ThermalCentre(vector(size * MICROMETRE_M, random))]


DECLARATION = Declaration(
    ThermalCentre,
    values=Values,
    recipes=(
        Recipe(
            name="thermal_eccentricity",
            unit="um/K",
            low=0.1,
            high=0.9,
            draw=draw,
            rank=10,
            coefficients=2,
        ),
    ),
)
