"""Checks whether the conditions vary enough to separate effects; several effects use them."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.observations import Observations

SPEED_RATIO = 1.2
"""Smallest ratio of two speeds that count as different speeds."""


def one_speed(observations: Observations) -> list[str]:
    """Return a message if the speeds of all rows of the capture are within the factor SPEED_RATIO
    of each other, without regard to the direction; otherwise return an empty list.

    At a single speed, an oscillation in time and an oscillation in angle look the same.
    """
    rows = observations.capture
    if rows is None:
        return []
    speeds = np.abs(rows.speed_rad_s)
    varied = float(speeds.max(initial=0.0)) > SPEED_RATIO * float(speeds.min(initial=np.inf))
    return [] if varied else ["runs at more than one speed"]


def one_velocity(observations: Observations) -> list[str]:
    """Return a message if all rows of the capture have one speed and one direction, to 0.001 rad/s;
    otherwise return an empty list."""
    rows = observations.capture
    if rows is None:
        return []
    speeds = np.unique(np.round(rows.speed_rad_s, 3))
    return [] if speeds.size > 1 else ["runs at more than one speed or direction"]
