"""Models the balls of the bearing, which move the axis at an order that is not a whole number."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number, Positive
from arctrue.table.cause import Cause, Points
from arctrue.table.declaration import (
    MICROMETRE_M,
    TURNS,
    Declaration,
    Given,
    Occasion,
    Random,
    Recipe,
    ellipse,
)
from arctrue.table.draws import vector
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class BallPass(Cause):
    """The cage turns more slowly than the table, so its balls move the axis at an
    order that is not a whole number.

    In the stator frame, with the unwrapped angle θ and the order ν, the axis is at forward·e^{jνθ}
    + backward·e^{−jνθ}, metres.
    """

    order: float
    forward_m: complex
    backward_m: complex = 0j

    def axis_shift_m(self, state: TableState) -> Points:
        """Return the displacement of the axis, shape ``(n,)``."""
        around = np.exp(1j * self.order * state.angle_rad)
        return np.asarray(self.forward_m * around + self.backward_m / around)


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    order: Positive
    forward_um: Number
    backward_um: Number = 0.0
    direction_deg: Number = 0.0

    def physical(self, lines: int) -> BallPass:
        """Return the cause that these values describe."""
        return BallPass(self.order, *ellipse(self.forward_um, self.backward_um, self.direction_deg))


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    order = float(np.round(random.uniform(0.35, 14.0), 2))
    share, metres = random.uniform(0.0, 1.0), size * MICROMETRE_M
    return [BallPass(order, vector(metres * share, random), vector(metres * (1 - share), random))]


DECLARATION = Declaration(
    BallPass,
    values=Values,
    recipes=(
        Recipe(
            name="bearing_ball_pass",
            unit="um",
            low=0.1,
            high=1.0,
            draw=draw,
            rank=4,
            coefficients=4,
            places=2 * TURNS * 14,
        ),
    ),
)
