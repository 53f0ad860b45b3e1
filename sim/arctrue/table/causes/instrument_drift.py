"""The stand of the instrument creeps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.cause import Cause, Stations


@dataclass(frozen=True, slots=True)
class InstrumentDrift(Cause):
    """The reference turns at a steady rate while the table is measured."""

    rate_rad_s: float

    def instrument_error_rad(
        self, stations: Stations, deviation_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """rate × time, shape ``(n,)``."""
        return self.rate_rad_s * stations.conditions.time_s
