"""Models a disc that the drive pushes to one side of its clearance; the side depends on the
direction of motion."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number
from arctrue.table.cause import Cause, Points
from arctrue.table.declaration import MICROMETRE_M, Declaration, Given
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class LooseCentre(Cause):
    """The drive pushes the disc by ``shift_m`` (x + jy, table frame) while the angle rises, and by
    −``shift_m`` while it falls; at rest the disc is centred."""

    shift_m: complex

    def disc_shift_m(self, state: TableState) -> Points:
        """Return the displacement in the frame of the turning table, metres, shape ``(n,)``."""
        return np.asarray(self.shift_m * np.sign(state.speed_rad_s))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    um: Number
    direction_deg: Number = 0.0

    def physical(self, lines: int) -> LooseCentre:
        """Return the cause that these values describe."""
        return LooseCentre(cmath.rect(self.um * MICROMETRE_M, math.radians(self.direction_deg)))


DECLARATION = Declaration(LooseCentre, values=Values)
