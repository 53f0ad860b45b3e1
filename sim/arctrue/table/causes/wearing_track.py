"""Models a bearing track that wears as the table turns."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number
from arctrue.table.cause import Cause, Points
from arctrue.table.conditions import travelled_turns
from arctrue.table.declaration import (
    MICROMETRE_M,
    Declaration,
    Given,
    Occasion,
    Order,
    Random,
    Recipe,
)
from arctrue.table.draws import angle
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class WearingTrack(Cause):
    """The axis moves ``order`` times a turn; the amplitude grows with every turn that the table has
    made.

    In the stator frame the axis moves along a line with the amplitude ``rate_m`` × turns; turns in
    both directions count.
    """

    order: int
    rate_m: float
    direction_rad: float
    phase_rad: float

    def axis_shift_m(self, state: TableState) -> Points:
        """Return the displacement of the axis, shape ``(n,)``.

        Raises ValueError if the conditions do not contain the travel.
        """
        wave = np.cos(self.order * state.angle_rad + self.phase_rad)
        size = travelled_turns(state) * wave
        return np.asarray(size * cmath.rect(self.rate_m, self.direction_rad))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    order: Order
    um_per_turn: Number
    direction_deg: Number = 0.0
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> WearingTrack:
        """Return the cause that these values describe."""
        return WearingTrack(
            self.order,
            self.um_per_turn * MICROMETRE_M,
            math.radians(self.direction_deg),
            math.radians(self.phase_deg),
        )


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    rate = size * MICROMETRE_M / max(occasion.turns, 1.0)
    return [WearingTrack(int(random.integers(2, 7)), rate, angle(random), angle(random))]


DECLARATION = Declaration(
    WearingTrack,
    values=Values,
    recipes=(
        Recipe(
            name="wearing_track",
            unit="um",
            low=0.2,
            high=2.0,
            draw=draw,
            rank=27,
            kind="stranger",
            coefficients=2,
            places=5,
        ),
    ),
)
