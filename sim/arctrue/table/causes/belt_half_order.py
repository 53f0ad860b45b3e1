"""A belt or a two-to-one gear that pulls every second turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class BeltPull(PhysicalEffect):
    """A belt twice as long as the pulley's circumference pulls the axis towards ``pull_rad``.

    Stator frame: the axis moves on a line by pull·cos(order·θ + phase), order a half-integer.
    """

    order: float
    pull_m: float
    pull_rad: float
    phase_rad: float

    def axis_shift_m(self, state: TableState) -> Points:
        """Displacement of the axis, shape ``(n,)``."""
        size = self.pull_m * np.cos(self.order * state.angle_rad + self.phase_rad)
        return np.asarray(size * np.exp(1j * self.pull_rad))
