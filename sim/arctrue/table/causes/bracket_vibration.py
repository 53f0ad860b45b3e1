"""A bracket shakes at its own frequency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.conditions import conditions_of
from arctrue.table.head import Head
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class BracketVibration(PhysicalEffect):
    """The head swings along the scale by ``amplitude_rad`` seen from the axis.

    Nothing ties its phase to the table: each run has one of its own (in a circle if there are
    more runs than phases).
    """

    head: int
    at: Head
    amplitude_rad: float
    frequency_hz: float
    phases_rad: tuple[float, ...] = (0.0,)

    def head_shift_m(self, head: int, state: TableState) -> Points | complex:
        """Displacement, metres, shape ``(n,)``."""
        if head != self.head:
            return 0j
        run = conditions_of(state).run % len(self.phases_rad)
        phase = 2 * np.pi * self.frequency_hz * state.time_s + np.asarray(self.phases_rad)[run]
        turn_rad = self.amplitude_rad * np.sin(phase)
        return np.asarray(self.at.point_m * (np.exp(1j * turn_rad) - 1))
