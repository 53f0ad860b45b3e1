"""Models a bracket that expands when it is warm and moves its head."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Angles, Cause
from arctrue.table.conditions import heating_k
from arctrue.table.declaration import Declaration, Given, HeadNumber, Occasion, Random, Recipe
from arctrue.table.draws import later_head, sign
from arctrue.table.rotary_table import HEADS
from arctrue.table.state import TableState
from arctrue.table.turned_head import TurnedHead


@dataclass(frozen=True, slots=True)
class BracketExpansion(TurnedHead):
    """The bracket of one head expands along the scale by ``rate_rad_per_k``, an angle at the
    axis."""

    rate_rad_per_k: float

    def turn_rad(self, state: TableState) -> Angles | float:
        """Return the angle by which the head is turned about the axis, radians, shape ``(n,)``."""
        return np.asarray(self.rate_rad_per_k * heating_k(state))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    arcsec_per_k: Number
    head: HeadNumber = 2

    def physical(self, lines: int) -> BracketExpansion:
        """Return the cause that these values describe."""
        head = self.head - 1
        return BracketExpansion(head, HEADS[head], self.arcsec_per_k * RAD_PER_ARCSEC)


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    rate, head = sign(random) * size * RAD_PER_ARCSEC, later_head(random, occasion)
    return [BracketExpansion(head, occasion.heads[head], rate)]


DECLARATION = Declaration(
    BracketExpansion,
    values=Values,
    recipes=(
        Recipe(
            name="thermal_head_drift",
            unit="arcsec/K",
            low=0.1,
            high=1.0,
            draw=draw,
            rank=9,
            coefficients=1,
        ),
    ),
)
