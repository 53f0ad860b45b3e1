"""The balls of the bearing come around at a rate of their own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class BallPass(PhysicalEffect):
    """The cage turns slower than the table: the axis moves at an order that is not whole.

    Stator frame, over the unwrapped angle: forward·e^{jνθ} + backward·e^{−jνθ}, metres.
    """

    order: float
    forward_m: complex
    backward_m: complex = 0j

    def axis_shift_m(self, state: TableState) -> Points:
        """Displacement of the axis, shape ``(n,)``."""
        around = np.exp(1j * self.order * state.angle_rad)
        return np.asarray(self.forward_m * around + self.backward_m / around)
