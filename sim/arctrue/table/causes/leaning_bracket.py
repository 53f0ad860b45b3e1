"""Models a bracket that the friction of a seal drags along with the disc."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number, Positive
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Angles, Cause
from arctrue.table.conditions import conditions_of
from arctrue.table.declaration import (
    STROKE_DEG,
    Declaration,
    Given,
    HeadNumber,
    Occasion,
    Random,
    Recipe,
)
from arctrue.table.draws import any_head, sign
from arctrue.table.rotary_table import HEADS
from arctrue.table.state import TableState
from arctrue.table.turned_head import TurnedHead


@dataclass(frozen=True, slots=True)
class LeaningBracket(TurnedHead):
    """The bracket of one head leans in the direction in which the disc turns, by angle × direction.

    After a reversal the head moves to the other side within ``stroke_rad`` of travel: the factor of
    the angle is −1 + 2·(1 − exp(−travel/stroke)). If the travel since the reversal is unknown, the
    factor is 1.
    """

    angle_rad: float
    stroke_rad: float

    def turn_rad(self, state: TableState) -> Angles | float:
        """Return the angle by which the head is turned about the axis, radians, shape ``(n,)``."""
        conditions = conditions_of(state)
        travel_rad = conditions.since_reversal_rad
        over = 1.0 if travel_rad is None else 1.0 - 2.0 * np.exp(-travel_rad / self.stroke_rad)
        return np.asarray(self.angle_rad * conditions.direction * over)


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    head: HeadNumber
    arcsec: Number
    stroke_deg: Positive = STROKE_DEG

    def physical(self, lines: int) -> LeaningBracket:
        """Return the cause that these values describe."""
        head, angle = self.head - 1, self.arcsec * RAD_PER_ARCSEC
        return LeaningBracket(head, HEADS[head], angle, math.radians(self.stroke_deg))


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    head, stroke = any_head(random, occasion), float(np.deg2rad(random.uniform(5.0, 60.0)))
    return [
        LeaningBracket(head, occasion.heads[head], sign(random) * size * RAD_PER_ARCSEC, stroke)
    ]


DECLARATION = Declaration(
    LeaningBracket,
    values=Values,
    recipes=(
        Recipe(
            name="leaning_bracket",
            unit="arcsec",
            low=0.2,
            high=3.0,
            draw=draw,
            rank=28,
            kind="stranger",
            coefficients=1,
            places=6,
        ),
    ),
)
