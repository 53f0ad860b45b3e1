"""The axis moves once or several times a turn, alike in every turn."""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class RadialMotion(PhysicalEffect):
    """Bearing tracks that are not round carry the axis around an ellipse ``order`` times a turn.

    Stator frame: centre = forward·e^{j·order·θ} + backward·e^{−j·order·θ}, metres; complex
    factors give the ellipse's size, shape and direction. With backward = 0 it is a circle.
    """

    order: int
    forward_m: complex
    backward_m: complex = 0j

    def axis_shift_m(self, state: TableState) -> Points:
        """Displacement of the axis, shape ``(n,)``."""
        around = np.exp(1j * self.order * state.angle_rad)
        return np.asarray(self.forward_m * around + self.backward_m / around)

    @classmethod
    def along(
        cls, order: int, amplitude_m: float, line_rad: float, phase_rad: float
    ) -> RadialMotion:
        """To and fro on a straight line in the direction ``line_rad``."""
        return cls(
            order,
            cmath.rect(amplitude_m / 2, line_rad + phase_rad),
            cmath.rect(amplitude_m / 2, line_rad - phase_rad),
        )
