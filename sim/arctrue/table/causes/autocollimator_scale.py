"""The autocollimator reads a little too much or too little."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.cause import Cause, Stations


@dataclass(frozen=True, slots=True)
class AutocollimatorScale(Cause):
    """Its scale is wrong by the share ``gain``: an error in proportion to what it shows."""

    gain: float

    def instrument_error_rad(
        self, stations: Stations, deviation_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """gain × deviation, shape ``(n,)``."""
        return self.gain * deviation_rad
