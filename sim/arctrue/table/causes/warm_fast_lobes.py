"""A disc that changes its shape when it is warm and turns fast."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.conditions import heating_k
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class WarmFastLobes(PhysicalEffect):
    """The warm adhesive yields to the centrifugal force: lobes ∝ heat × speed²."""

    order: int
    rate_rad_s2_per_k: float
    phase_rad: float

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """What the lines say too much, shape ``(n,)``."""
        wave = np.cos(self.order * disc_angle_rad + self.phase_rad)
        load = heating_k(state) * state.speed_rad_s**2
        return np.asarray(self.rate_rad_s2_per_k * load * wave)
