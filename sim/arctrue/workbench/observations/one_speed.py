"""Finds whether all rows have one speed, at which an order and a frequency look the same."""

from __future__ import annotations

from collections.abc import Iterator
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
    for speed, duration_s, uneven in passes_of(turns, time_s, rows.run):
        if uneven * highest_order > SAME_PHASE_TURNS:
            return None
        speeds.append(speed)
        durations.append(duration_s)
    if not speeds or max(speeds) <= 0.0:
        return None
    apart = (max(speeds) - min(speeds)) * max(durations) * highest_order
    return float(np.median(speeds)) if apart < SAME_PHASE_TURNS else None


def order_at_one_speed(rows: CaptureRows | ReferenceRows, hz: float) -> float | None:
    """Return the order that equals a frequency at the common speed of all passes; None without such
    a speed."""
    turns, time_s = coordinate(rows, in_time=False), coordinate(rows, in_time=True)
    if turns is None or time_s is None:
        return None
    speeds = [speed for speed, _, _ in passes_of(turns, time_s, rows.run)]
    usual = float(np.median(speeds)) if speeds else 0.0
    speed = speed_turns_s(rows, hz / usual) if usual > 0.0 else None
    return None if speed is None else hz / speed


def passes_of(
    turns: Float, time_s: Float, run: NDArray[np.int64]
) -> Iterator[tuple[float, float, float]]:
    """Yield, for each pass, its speed in turns per second without sign, its duration in seconds and
    its largest deviation from a uniform motion in turns, infinite without a duration."""
    for part in _passes(turns, run):
        since = time_s[part] - time_s[part].mean()
        square = float(since @ since)
        if square <= 0.0:
            yield 0.0, 0.0, float("inf")
            continue
        away = turns[part] - turns[part].mean()
        slope = float(since @ away) / square
        yield abs(slope), float(np.ptp(time_s[part])), float(np.abs(away - slope * since).max())


def _passes(turns: Float, run: NDArray[np.int64]) -> list[slice]:
    """Return the rows of each pass, between changes of the run or of the sense of motion; a pass
    has at least LEAST_PASS_ROWS rows."""
    sense = np.sign(np.diff(turns))
    new = np.diff(run) != 0
    new[1:] |= (sense[1:] * sense[:-1] < 0.0) & ~new[:-1]
    bounds = [0, *(np.flatnonzero(new) + 1).tolist(), turns.size]
    return [slice(start, end) for start, end in pairwise(bounds) if end - start >= LEAST_PASS_ROWS]
