"""A scratch, dirt or a splice on the graduation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class GraduationBump(PhysicalEffect):
    """The lines around one place of the disc lie off by height·exp(−|away/width|^power/2).

    Power 2 is a bell of 1 sigma; more has a flat top and steep edges (dirt, a splice), less a sharp
    top (a scratch). ``skew`` makes one side wider and the other narrower: width·(1 ± skew).
    """

    height_rad: float
    place_rad: float
    width_rad: float
    power: float = 2.0
    skew: float = 0.0

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """The bump at each disc angle, shape ``(n,)``; half a turn away it is nothing."""
        away = np.angle(np.exp(1j * (disc_angle_rad - self.place_rad)))
        width = self.width_rad * (1.0 + self.skew * np.sign(away))
        return np.asarray(self.height_rad * np.exp(-0.5 * np.abs(away / width) ** self.power))
