"""A disc that changes its shape when it is warm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.conditions import heating_k
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class WarmLobes(PhysicalEffect):
    """The lines shift ``order`` times a turn in proportion to heat (2: the disc ovalises)."""

    order: int
    rate_rad_per_k: float
    phase_rad: float

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """What the lines say too much, shape ``(n,)``."""
        wave = np.cos(self.order * disc_angle_rad + self.phase_rad)
        return np.asarray(self.rate_rad_per_k * heating_k(state) * wave)
