"""Checks of the variety of conditions that several effects need for their separation."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.observations import Observations

SPEED_RATIO = 1.2
"""Smallest ratio of two speeds that count as different."""


def one_speed(observations: Observations) -> list[str]:
    """Return a message if all runs of the capture have one magnitude of speed; else nothing.

    An oscillation in time and one in angle are the same thing at a single speed.
    """
    rows = observations.capture
    if rows is None:
        return []
    speeds = np.abs(rows.speed_rad_s)
    varied = float(speeds.max(initial=0.0)) > SPEED_RATIO * float(speeds.min(initial=np.inf))
    return [] if varied else ["runs at more than one speed"]


def one_velocity(observations: Observations) -> list[str]:
    """Return a message if all runs of the capture have one signed speed; else nothing."""
    rows = observations.capture
    if rows is None:
        return []
    speeds = np.unique(np.round(rows.speed_rad_s, 3))
    return [] if speeds.size > 1 else ["runs at more than one speed or direction"]
