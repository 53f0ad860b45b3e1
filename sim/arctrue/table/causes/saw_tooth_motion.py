"""Models a cam that moves the axis away slowly and then lets it return fast."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta

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
)
from arctrue.table.draws import angle
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class SawToothMotion(Cause):
    """The axis moves along a line from −amplitude to +amplitude and back, ``order`` times a turn.

    ``rise`` is the share of a period in which the axis moves to +amplitude (½: a triangle; near 1:
    a saw tooth). The displacement is in the stator frame.
    """

    order: int
    amplitude_m: float
    direction_rad: float
    phase_rad: float
    rise: float

    def axis_shift_m(self, state: TableState) -> Points:
        """Return the displacement of the axis, shape ``(n,)``."""
        share = np.mod((self.order * state.angle_rad + self.phase_rad) / (2 * np.pi), 1.0)
        wave = np.interp(share, [0.0, self.rise, 1.0], [-1.0, 1.0, -1.0])
        return np.asarray(wave * cmath.rect(self.amplitude_m, self.direction_rad))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    order: Order
    um: Number
    direction_deg: Number = 0.0
    phase_deg: Number = 0.0
    rise: Annotated[float, Meta(ge=0.01, le=0.99)] = 0.9

    def physical(self, lines: int) -> SawToothMotion:
        """Return the cause that these values describe."""
        return SawToothMotion(
            self.order,
            self.um * MICROMETRE_M,
            math.radians(self.direction_deg),
            math.radians(self.phase_deg),
            self.rise,
        )


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    order, rise = int(random.integers(2, 6)), float(random.uniform(0.8, 0.97))
    return [SawToothMotion(order, size * MICROMETRE_M, angle(random), angle(random), rise)]


DECLARATION = Declaration(
    SawToothMotion,
    values=Values,
    recipes=(
        Recipe(
            name="saw_tooth_motion",
            unit="um",
            low=0.1,
            high=1.0,
            draw=draw,
            rank=23,
            kind="stranger",
            coefficients=2,
            places=4 * 6,
        ),
    ),
)
