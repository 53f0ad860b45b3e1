"""Models a belt or a two-to-one gear that pulls the axis once in two turns."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number, Positive
from arctrue.table.cause import Cause, Points
from arctrue.table.declaration import MICROMETRE_M, Declaration, Given, Occasion, Random, Recipe
from arctrue.table.draws import angle, sign
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class BeltPull(Cause):
    """A belt twice as long as the pulley's circumference pulls the axis towards ``pull_rad`` once
    in two turns.

    In the stator frame the axis moves along a line by pull·cos(order·θ + phase), where the order is
    a half-integer.
    """

    order: float
    pull_m: float
    pull_rad: float
    phase_rad: float

    def axis_shift_m(self, state: TableState) -> Points:
        """Return the displacement of the axis, shape ``(n,)``."""
        size = self.pull_m * np.cos(self.order * state.angle_rad + self.phase_rad)
        return np.asarray(size * np.exp(1j * self.pull_rad))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    order: Positive
    um: Number
    direction_deg: Number = 0.0
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> BeltPull:
        """Return the cause that these values describe."""
        return BeltPull(
            self.order,
            self.um * MICROMETRE_M,
            math.radians(self.direction_deg),
            math.radians(self.phase_deg),
        )


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    along = sign(random) * float(random.uniform(0.0, np.pi))
    order = float(random.choice([0.5, 1.5, 2.5]))
    return [BeltPull(order, size * MICROMETRE_M, along, angle(random))]


DECLARATION = Declaration(
    BeltPull,
    values=Values,
    recipes=(
        Recipe(
            name="half_order",
            unit="um",
            low=0.1,
            high=1.0,
            draw=draw,
            rank=20,
            kind="parts",
            parts=("order:*", "stator"),
            coefficients=2,
            coefficients_of_more_heads=4,
        ),
    ),
)
