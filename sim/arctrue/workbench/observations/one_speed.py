"""Finds whether all rows have one speed, at which an order and a frequency look the same."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.observations.rows import CaptureRows, Float, ReferenceRows

SAME_PHASE_TURNS = 0.25
"""A speed counts as steady if the angle deviates from a uniform motion by at most this number of
periods of the highest order."""
LEAST_PASS_ROWS = 8
"""Smallest number of rows of a pass. A speed and its scatter need several steps; shorter passes
occur where the drive reverses.
"""


def coordinate(rows: CaptureRows | ReferenceRows, *, in_time: bool) -> Float | None:
    """Return the unwrapped angle in turns, or the time in seconds, of every row; None without a
    time."""
    return rows.time_s if in_time else rows.angle_rad / (2.0 * np.pi)


def speed_turns_s(rows: CaptureRows | ReferenceRows, highest_order: float) -> float | None:
    """Return the common speed of all passes, turns per second; at one speed, an order equals a
    frequency.

    The result is None without a time, or if speeds differ: data with several speeds show whether a
    periodic error is fixed to the angle or to the time. Equal speeds forwards and backwards count
    as one speed: an order and a frequency then differ only in the phase of the backward runs, and a
    lag may change this phase too.
    """
    turns, time_s = coordinate(rows, in_time=False), coordinate(rows, in_time=True)
    if turns is None or time_s is None or highest_order <= 0.0:
        return None
    speeds, durations = [], []
    for part in _passes(turns, rows.run):
        since = time_s[part] - time_s[part].mean()
        square = float(since @ since)
        if square <= 0.0:
            return None
        away = turns[part] - turns[part].mean()
        slope = float(since @ away) / square
        if float(np.abs(away - slope * since).max()) * highest_order > SAME_PHASE_TURNS:
            return None
        speeds.append(abs(slope))
        durations.append(float(np.ptp(time_s[part])))
    if not speeds or max(speeds) <= 0.0:
        return None
    apart = (max(speeds) - min(speeds)) * max(durations) * highest_order
    return float(np.median(speeds)) if apart < SAME_PHASE_TURNS else None


def _passes(turns: Float, run: NDArray[np.int64]) -> list[slice]:
    """Return the rows of each pass, between changes of the run or of the sense of motion; a pass
    has at least LEAST_PASS_ROWS rows."""
    sense = np.sign(np.diff(turns))
    new = np.diff(run) != 0
    new[1:] |= (sense[1:] * sense[:-1] < 0.0) & ~new[:-1]
    bounds = [0, *(np.flatnonzero(new) + 1).tolist(), turns.size]
    return [slice(start, end) for start, end in pairwise(bounds) if end - start >= LEAST_PASS_ROWS]
