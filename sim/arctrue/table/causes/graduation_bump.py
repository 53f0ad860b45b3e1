"""A scratch, dirt or a splice on the graduation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class GraduationBump(PhysicalEffect):
    """The lines around one place of the disc lie off, as a bell of the given width (1 sigma)."""

    height_rad: float
    place_rad: float
    width_rad: float

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """The bell at each disc angle, shape ``(n,)``; beyond half a turn away it is nothing."""
        away = np.angle(np.exp(1j * (disc_angle_rad - self.place_rad)))
        return np.asarray(self.height_rad * np.exp(-0.5 * (away / self.width_rad) ** 2))
