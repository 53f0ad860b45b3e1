"""A bracket that sticks, is loaded, and slips."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.head import Head
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class StickingBracket(PhysicalEffect):
    """Between two slips the head creeps along the scale at one rate; a slip takes it back.

    ``slips_s`` are the instants at which it slips, rising; it creeps from −angle to +angle in the
    mean of their distances, so a longer wait ends farther away.
    """

    head: int
    at: Head
    angle_rad: float
    slips_s: tuple[float, ...]

    def head_shift_m(self, head: int, state: TableState) -> Points | complex:
        """From where the head should be to where it is, metres, shape ``(n,)``."""
        if head != self.head:
            return 0j
        slips = np.asarray(self.slips_s)
        since = np.searchsorted(slips, state.time_s, side="right") - 1
        waited_s = state.time_s - slips[np.maximum(since, 0)]
        turn_rad = self.angle_rad * (2.0 * waited_s / np.diff(slips).mean() - 1.0)
        return np.asarray(self.at.point_m * (np.exp(1j * turn_rad) - 1))
