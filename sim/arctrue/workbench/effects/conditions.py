"""Checks whether the conditions vary enough to separate effects; several effects use these
checks."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.observations import Observations

SPEED_RATIO = 1.2
"""Smallest ratio of two speeds that count as different speeds."""
SAME_SPEED = 0.01
"""Largest difference of two signed speeds that count as one speed, divided by the largest speed."""


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
    """Return a message if all rows of the capture have one speed and one direction; otherwise
    return an empty list. The signed speeds may differ by the share SAME_SPEED of the largest
    speed."""
    rows = observations.capture
    if rows is None:
        return []
    speed = rows.speed_rad_s
    spread = float(np.ptp(speed)) if speed.size else 0.0
    varied = spread > SAME_SPEED * float(np.abs(speed).max(initial=0.0))
    return [] if varied else ["runs at more than one speed or direction"]
