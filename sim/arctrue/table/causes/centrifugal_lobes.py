"""A disc that the centrifugal force stretches unevenly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class CentrifugalLobes(PhysicalEffect):
    """The lines shift ``order`` times a turn in proportion to the speed squared."""

    order: int
    stretch_rad_s2: float
    phase_rad: float

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """What the lines say too much, shape ``(n,)``."""
        wave = np.cos(self.order * disc_angle_rad + self.phase_rad)
        return np.asarray(self.stretch_rad_s2 * state.speed_rad_s**2 * wave)
