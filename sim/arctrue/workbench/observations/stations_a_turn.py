"""Number of stations of a reference in a turn."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.observations import ReferenceRows

STATION_DECIMALS = 6
"""Number of decimals of a radian to which stations are rounded; stations with equal rounded angles
count as one."""
LARGEST_GAP_STEPS = 8.0
"""A reference run covers a whole turn if its largest gap is shorter than this number of its median
steps."""


def stations_a_turn(rows: ReferenceRows) -> float:
    """Return the number of reference stations in a turn, calculated from the median step.

    The result is 0 if the stations do not cover the whole turn.
    """
    # The gap from the last station to the first counts too: on an arc this gap is many steps long.
    place = np.unique(np.round(np.mod(rows.target_rad, 2.0 * np.pi), STATION_DECIMALS))
    steps = np.abs(np.diff(rows.target_rad))[np.diff(rows.run) == 0]
    moved = steps[steps > 10.0**-STATION_DECIMALS]
    if place.size < 3 or moved.size == 0:
        return 0.0
    step = float(np.median(moved))
    widest = float(np.diff(place, append=place[0] + 2.0 * np.pi).max())
    return 2.0 * np.pi / step if widest < LARGEST_GAP_STEPS * step else 0.0
