"""A head whose screws come loose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.head import Head
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class LooseningHead(PhysicalEffect):
    """The head knocks between two stops, at instants of no rule, and the play grows with time.

    Play = ``angle_rad``·(time/last instant), to alternate sides from knock to knock.
    """

    head: int
    at: Head
    angle_rad: float
    knocks_s: tuple[float, ...]

    def head_shift_m(self, head: int, state: TableState) -> Points | complex:
        """From where the head should be to where it is, metres, shape ``(n,)``."""
        if head != self.head:
            return 0j
        knocks = np.asarray(self.knocks_s)
        side = np.where(np.searchsorted(knocks, state.time_s) % 2 == 0, 1.0, -1.0)
        turn_rad = self.angle_rad * side * state.time_s / knocks[-1]
        return np.asarray(self.at.point_m * (np.exp(1j * turn_rad) - 1))
