"""Unwraps the angles of a log that its recorder wrote modulo one turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from arctrue.measurement import Reference
from arctrue.workbench.observations.reference_speed import MOVING_STEP_DEG

NO_PAUSE = 3.0
"""Largest time between the rows on both sides of a wrap, in median steps. Two rows may be missing
at the wrap, but the table cannot have gone back by a turn in this time."""


def unwrapped(columns: Reference) -> Reference:
    """Return the columns; if the log is wrapped, its angles are continued past a turn.

    A log is wrapped if its rows are close together and within one turn, and if in some places the
    angle jumps by about a turn between two successive readings of a run. Without this
    correction, orders that are not integers could not be found, because such orders have another
    phase in each turn. Between two rows, also of different runs, the table is assumed to have moved
    by less than half a turn.
    """
    target, time_s = columns.target_deg, columns.time_s
    if time_s is None or target.size < 3:
        return columns
    steps, taken_s = np.diff(target), np.diff(time_s)
    inside = np.ones(steps.size, dtype=bool) if columns.run is None else np.diff(columns.run) == 0
    if not inside.any() or float(np.ptp(target)) > 360.0:
        return columns
    usual_deg = float(np.median(np.abs(steps[inside])))
    usual_s = float(np.median(taken_s[inside]))
    shortest = steps - 360.0 * np.round(steps / 360.0)
    jumps = inside & (np.abs(steps - shortest) > 180.0) & (taken_s <= NO_PAUSE * usual_s)
    jumps &= np.abs(shortest) <= NO_PAUSE * MOVING_STEP_DEG
    if usual_deg > MOVING_STEP_DEG or usual_s <= 0.0 or not jumps.any():
        return columns
    return replace(columns, target_deg=target[0] + np.concatenate([[0.0], np.cumsum(shortest)]))
