"""The stand of the instrument creeps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.cause import Cause, Stations


@dataclass(frozen=True, slots=True)
class InstrumentDrift(Cause):
    """The reference turns while the table is measured, as the temperature of its stand wanders.

    A steady rate, and on top the turn at each knot, straight in between, constant outside.
    """

    rate_rad_s: float
    knots_s: tuple[float, ...] = (0.0,)
    turns_rad: tuple[float, ...] = (0.0,)

    def instrument_error_rad(
        self, stations: Stations, deviation_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """rate × time and what the temperature adds, shape ``(n,)``."""
        time_s = stations.conditions.time_s
        wandering = np.interp(time_s, self.knots_s, self.turns_rad)
        return np.asarray(self.rate_rad_s * time_s + wandering)
