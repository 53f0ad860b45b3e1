"""Computes the conditions of a table that stops at one station after another, where a reference
instrument is read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.table.conditions import USUAL_TEMPERATURE_C, Conditions

OVERRUN_RAD = float(np.deg2rad(5.0))
"""Angle by which the table moves past a station at which it reverses."""
NO_RUN = -1
"""Run number of every station, because stations belong to no run of the capture."""


def stations(
    time_s: NDArray[np.float64],
    target_rad: NDArray[np.float64],
    direction: NDArray[np.int64] | NDArray[np.float64],
    speed_rad_s: NDArray[np.float64] | float = 0.0,
) -> Conditions:
    """Return the conditions at stations, arrays ``(n,)``; the table reaches each station from its
    ``direction``.

    The table is at the usual temperature, long after the start. At the first station after a
    reversal the table moves five degrees too far and approaches the station again, as the procedure
    requires.
    """
    travelled_rad, since_rad = _travel(target_rad, np.asarray(direction, dtype=np.float64))
    return Conditions(
        time_s,
        target_rad,
        np.broadcast_to(np.asarray(speed_rad_s, dtype=np.float64), time_s.shape),
        np.full(time_s.shape, USUAL_TEMPERATURE_C),
        np.asarray(direction, dtype=np.float64),
        np.full(time_s.shape, NO_RUN, dtype=np.int64),
        np.full(time_s.shape, np.inf),
        travelled_rad,
        since_rad,
    )


def _travel(
    target_rad: NDArray[np.float64], direction: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the travel in both directions until each station, and the travel since the latest
    change of direction."""
    steps = np.abs(np.diff(target_rad, prepend=target_rad[:1]))
    # Between two passes the target angle may jump by almost a turn, although the table moves only
    # one step.
    turns = np.minimum(steps, np.abs(2 * np.pi - steps))
    changed = np.diff(direction, prepend=0.0) != 0
    travel = np.cumsum(np.where(changed, 0.0, turns))
    begun = np.maximum.accumulate(np.where(changed, np.arange(travel.size), 0))
    overruns = np.cumsum(np.where(changed, 2 * OVERRUN_RAD, 0.0))
    return travel + overruns, np.asarray(OVERRUN_RAD + travel - travel[begun])
