"""A bracket that settles after the start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.conditions import conditions_of
from arctrue.table.head import Head
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class SettlingBracket(PhysicalEffect):
    """The bracket of one head creeps back along the scale: angle·exp(−t/τ) seen from the axis.

    With ``each_run`` the time counts from the start of every run, else from the first.
    """

    head: int
    at: Head
    angle_rad: float
    time_constant_s: float
    each_run: bool = False

    def head_shift_m(self, head: int, state: TableState) -> Points | complex:
        """From where the head should be to where it is, metres, shape ``(n,)``."""
        if head != self.head:
            return 0j
        conditions = conditions_of(state)
        since_s = conditions.since_run_start_s if self.each_run else conditions.time_s
        turn_rad = self.angle_rad * np.exp(-since_s / self.time_constant_s)
        return np.asarray(self.at.point_m * (np.exp(1j * turn_rad) - 1))
