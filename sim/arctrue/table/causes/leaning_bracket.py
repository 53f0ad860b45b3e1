"""A bracket that the seal's friction drags along with the disc."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.conditions import conditions_of
from arctrue.table.head import Head
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class LeaningBracket(PhysicalEffect):
    """One head leans to the side to which the disc turns: angle × direction.

    After a reversal it goes over from the other side within ``stroke_rad``
    of travel: −1 + 2·(1 − exp(−travel/stroke)).
    """

    head: int
    at: Head
    angle_rad: float
    stroke_rad: float

    def head_shift_m(self, head: int, state: TableState) -> Points | complex:
        """From where the head should be to where it is, metres, shape ``(n,)``."""
        if head != self.head:
            return 0j
        conditions = conditions_of(state)
        travel_rad = conditions.since_reversal_rad
        over = 1.0 if travel_rad is None else 1.0 - 2.0 * np.exp(-travel_rad / self.stroke_rad)
        turn_rad = self.angle_rad * conditions.direction * over
        return np.asarray(self.at.point_m * (np.exp(1j * turn_rad) - 1))
