"""A flat place in the track of the bearing."""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class FlatTrack(PhysicalEffect):
    """The axis dips towards ``direction_rad`` where the table stands about ``place_rad``.

    Stator frame; the dip is a bell over the table's angle, of the given width (1 sigma).
    """

    depth_m: float
    direction_rad: float
    place_rad: float
    width_rad: float

    def axis_shift_m(self, state: TableState) -> Points:
        """Displacement of the axis, shape ``(n,)``."""
        away = np.angle(np.exp(1j * (state.angle_rad - self.place_rad)))
        dip = np.exp(-0.5 * (away / self.width_rad) ** 2)
        return np.asarray(dip * cmath.rect(self.depth_m, self.direction_rad))
