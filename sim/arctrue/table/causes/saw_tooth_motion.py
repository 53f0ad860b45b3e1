"""A cam that carries the axis away slowly and lets it snap back."""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class SawToothMotion(PhysicalEffect):
    """The axis moves on a line, ``order`` times a turn, from −amplitude to +amplitude and back.

    ``rise`` is the share of a period that the way there takes (½: a triangle; near 1: a saw).
    Stator frame.
    """

    order: int
    amplitude_m: float
    direction_rad: float
    phase_rad: float
    rise: float

    def axis_shift_m(self, state: TableState) -> Points:
        """Displacement of the axis, shape ``(n,)``."""
        share = np.mod((self.order * state.angle_rad + self.phase_rad) / (2 * np.pi), 1.0)
        wave = np.interp(share, [0.0, self.rise, 1.0], [-1.0, 1.0, -1.0])
        return np.asarray(wave * cmath.rect(self.amplitude_m, self.direction_rad))
