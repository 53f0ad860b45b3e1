"""The reference instrument sits beside the axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.cause import Cause, Stations


@dataclass(frozen=True, slots=True)
class InstrumentEccentricity(Cause):
    """The instrument's own centre is ``offset_m`` off the axis; it is read at ``radius_m``.

    The ray from its centre to the reading point turns against the table: exact triangle.
    """

    offset_m: float
    radius_m: float
    phase_rad: float

    def instrument_error_rad(
        self, stations: Stations, deviation_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Angle between the two rays, shape ``(n,)``."""
        own_angle = stations.conditions.angle_rad - stations.turned_rad
        centre = self.offset_m * np.exp(1j * (own_angle + self.phase_rad))
        return np.asarray(np.angle((self.radius_m - centre) / self.radius_m))
