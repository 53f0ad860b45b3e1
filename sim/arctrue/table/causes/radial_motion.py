"""Models a motion of the axis that every turn repeats."""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number
from arctrue.table.cause import Cause, Points
from arctrue.table.declaration import (
    MICROMETRE_M,
    Declaration,
    Given,
    Occasion,
    Order,
    Random,
    Recipe,
    ellipse,
)
from arctrue.table.draws import vector
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class RadialMotion(Cause):
    """Bearing tracks that are not round move the axis on an ellipse ``order`` times a turn.

    In the stator frame the axis is at forward·e^{j·order·θ} + backward·e^{−j·order·θ}, metres; the
    two complex factors give the ellipse's size, shape and direction. With backward = 0 it is a
    circle.
    """

    order: int
    forward_m: complex
    backward_m: complex = 0j

    def axis_shift_m(self, state: TableState) -> Points:
        """Return the displacement of the axis, shape ``(n,)``."""
        around = np.exp(1j * self.order * state.angle_rad)
        return np.asarray(self.forward_m * around + self.backward_m / around)

    @classmethod
    def along(
        cls, order: int, amplitude_m: float, line_rad: float, phase_rad: float
    ) -> RadialMotion:
        """Return a motion back and forth on a straight line in the direction ``line_rad``."""
        return cls(
            order,
            cmath.rect(amplitude_m / 2, line_rad + phase_rad),
            cmath.rect(amplitude_m / 2, line_rad - phase_rad),
        )


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    order: Order
    forward_um: Number
    backward_um: Number = 0.0
    direction_deg: Number = 0.0

    def physical(self, lines: int) -> RadialMotion:
        """Return the cause that these values describe."""
        circles = ellipse(self.forward_um, self.backward_um, self.direction_deg)
        return RadialMotion(self.order, *circles)


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    # At order 1 two heads cannot separate a motion of the axis from an eccentric disc.
    lowest = 2 if len(occasion.heads) == 2 else 1
    order, share = int(random.integers(lowest, 9)), random.uniform(0.0, 1.0)
    metres = size * MICROMETRE_M
    return [
        RadialMotion(order, vector(metres * share, random), vector(metres * (1 - share), random))
    ]


DECLARATION = Declaration(
    RadialMotion,
    values=Values,
    recipes=(
        Recipe(
            name="radial_error_motion",
            unit="um",
            low=0.1,
            high=2.0,
            draw=draw,
            rank=3,
            coefficients=2,
            coefficients_of_more_heads=4,
            places=7,
        ),
    ),
)
