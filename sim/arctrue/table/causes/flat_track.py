"""Models a flat place in the track of the bearing."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number, Positive
from arctrue.table.cause import Cause, Points
from arctrue.table.declaration import MICROMETRE_M, Declaration, Given, Occasion, Random, Recipe
from arctrue.table.draws import angle
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class FlatTrack(Cause):
    """The axis dips towards ``direction_rad`` while the table is near ``place_rad``.

    The displacement is in the stator frame; over the table's angle it is a Gaussian curve of the
    given width (1 sigma).
    """

    depth_m: float
    direction_rad: float
    place_rad: float
    width_rad: float

    def axis_shift_m(self, state: TableState) -> Points:
        """Return the displacement of the axis, shape ``(n,)``."""
        away = np.angle(np.exp(1j * (state.angle_rad - self.place_rad)))
        dip = np.exp(-0.5 * (away / self.width_rad) ** 2)
        return np.asarray(dip * cmath.rect(self.depth_m, self.direction_rad))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    um: Number
    width_deg: Positive
    direction_deg: Number = 0.0
    place_deg: Number = 0.0

    def physical(self, lines: int) -> FlatTrack:
        """Return the cause that these values describe."""
        return FlatTrack(
            self.um * MICROMETRE_M,
            math.radians(self.direction_deg),
            math.radians(self.place_deg),
            math.radians(self.width_deg),
        )


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    width = float(np.deg2rad(random.uniform(3.0, 10.0)))
    return [FlatTrack(size * MICROMETRE_M, angle(random), angle(random), width)]


DECLARATION = Declaration(
    FlatTrack,
    values=Values,
    recipes=(
        Recipe(
            name="flat_track",
            unit="um",
            low=0.2,
            high=2.0,
            draw=draw,
            rank=22,
            kind="stranger",
            coefficients=2,
            places=360 / 3.0,
        ),
    ),
)
