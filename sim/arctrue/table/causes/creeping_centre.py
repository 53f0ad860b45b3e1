"""Models a disc that creeps on its hub as the table turns."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number
from arctrue.table.cause import Cause, Points
from arctrue.table.conditions import travelled_turns
from arctrue.table.declaration import MICROMETRE_M, Declaration, Given
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class CreepingCentre(Cause):
    """A clamp yields, and the disc moves by ``rate_m`` (x + jy, table frame) in each turn."""

    rate_m: complex

    def disc_shift_m(self, state: TableState) -> Points:
        """Return the displacement in the frame of the turning table, metres, shape ``(n,)``.

        Raises ValueError if the conditions do not contain the travel.
        """
        return np.asarray(self.rate_m * travelled_turns(state))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    um_per_turn: Number
    direction_deg: Number = 0.0

    def physical(self, lines: int) -> CreepingCentre:
        """Return the cause that these values describe."""
        direction_rad = math.radians(self.direction_deg)
        return CreepingCentre(cmath.rect(self.um_per_turn * MICROMETRE_M, direction_rad))


DECLARATION = Declaration(
    CreepingCentre,
    values=Values,
)
