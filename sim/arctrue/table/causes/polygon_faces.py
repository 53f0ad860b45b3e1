"""The faces of the polygon are not where their numbers say."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.cause import Cause, Stations


@dataclass(frozen=True, slots=True)
class PolygonFaces(Cause):
    """Each face leans by its own angle."""

    errors_rad: tuple[float, ...]

    def instrument_error_rad(
        self, stations: Stations, deviation_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Error of the face that is looked at, shape ``(n,)``."""
        return np.asarray(self.errors_rad)[stations.face % len(self.errors_rad)]
