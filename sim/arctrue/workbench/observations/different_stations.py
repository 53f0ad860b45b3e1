"""Counts the different stations of a reference."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

STATION_DECIMALS = 3
"""Decimals of a degree to which targets are rounded to count the different stations: 3.6″, more
than the rounding of a file and less than the distance of two stations."""


def stations_of(target_deg: NDArray[np.float64]) -> int:
    """Return the number of different stations; 359.9999° is the station 0°."""
    return int(np.unique(np.mod(np.round(target_deg, STATION_DECIMALS), 360.0)).size)
