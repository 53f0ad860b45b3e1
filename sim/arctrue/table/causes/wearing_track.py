"""A bearing track that wears out as the table turns."""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.conditions import travelled_turns
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class WearingTrack(PhysicalEffect):
    """The axis moves ``order`` times a turn, more with every turn that the table has made.

    On a line in the stator frame, by ``rate_m`` × turns travelled in either direction.
    """

    order: int
    rate_m: float
    direction_rad: float
    phase_rad: float

    def axis_shift_m(self, state: TableState) -> Points:
        """Displacement of the axis, shape ``(n,)``. Raises ValueError without the travel."""
        wave = np.cos(self.order * state.angle_rad + self.phase_rad)
        size = travelled_turns(state) * wave
        return np.asarray(size * cmath.rect(self.rate_m, self.direction_rad))
