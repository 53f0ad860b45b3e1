"""A bracket that grows with heat carries its head along."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.conditions import heating_k
from arctrue.table.head import Head
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class BracketExpansion(PhysicalEffect):
    """The bracket of one head grows along the scale, ``rate_rad_per_k`` seen from the axis."""

    head: int
    at: Head
    rate_rad_per_k: float

    def head_shift_m(self, head: int, state: TableState) -> Points | complex:
        """From where the head should be to where it is, metres, shape ``(n,)``."""
        if head != self.head:
            return 0j
        turn_rad = self.rate_rad_per_k * heating_k(state)
        return np.asarray(self.at.point_m * (np.exp(1j * turn_rad) - 1))
