"""Finds whether the table stood still at the stations of a reference run or passed them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import Reference
from arctrue.workbench.observations.run_speed import run_speeds

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

MOVING_STEP_DEG = 1.0
"""Largest median step of a pass whose rows are close together, and which is therefore in motion; a
run with stops has larger steps."""
LEAST_STOP_S = 0.2
"""Shortest time between two readings of a table that stops at its stations: a servo needs some
tenths of a second to stop and to settle. This limit is a choice."""
LEAST_ROWS = 8
"""Smallest number of rows for a median of six second differences: with fewer rows, one odd row
decides the median."""
EVEN = 0.05
"""Relative tolerance of the test for a steady speed: whether the times between stations are
proportional to their distances."""
FINEST_DECIMALS = 6
"""Largest number of decimals of a time that is examined: a microsecond is finer than EVEN of every
step between stations."""
WHOLE_STEPS = 1e-3
"""Largest deviation of a time from a whole number of its rounding steps, in steps: a float64 holds
10⁹ s to 6·10⁻⁸ s, which is less than this share of a step of four decimals."""
FINE_ROUNDING = 0.1
"""Largest rounding step, relative to the time between stations, with which single times between
stations still show a steady speed: twice EVEN. With coarser times, the whole pass must fit a
line."""
MOST_ROUNDING = 0.5
"""Largest rounding step, relative to the time between stations, with which a pass can show a steady
speed: with coarser times, successive stations may have the same time."""
TARGET_NOISE_RAD = np.radians(1e-4)
"""Noise of a target angle that is commanded, or read from a finer encoder, and written with four
decimals."""
HALF_TURN_DEG = 180.0
"""A longer step between two rows leads over the end of a turn, because the way in the other sense
is shorter."""
BLOCK_ROWS = 4096
"""Number of rows that are searched at once for the end of a turn; it limits processor time only."""
SPEED_RATIO = 1.2
"""If two passes over the same stations have speeds with a larger ratio than this, they cannot
consist of stops of equal length."""


SMOOTH = 0.2
"""Largest median of the relative differences of neighbouring distances between rows. A speed
changes smoothly, but the distances of freely chosen stations do not."""


def reference_speed(columns: Reference) -> Float | None:
    """Return the signed speed of every row, rad/s, 0 where the table stood; None without motion.

    A pass is a sequence of rows between two changes of run, cycle, direction, or the sense in which
    the targets follow each other. Five kinds of passes are in motion. First, passes over stations
    close together. Second, passes that a clock sampled while the speed changed (a ramp): their
    times are even and their distances uneven. Third, passes over stations far apart (a polygon's
    faces), if their times fit steady speeds and at least two of the speeds differ: a table that
    stops takes about as long at each station in every pass. Fourth, passes over stations far apart
    at a steady speed, if their time steps equal those of a pass of the first two kinds. A clock
    then sampled both, and the fast pass belongs to the same log. Fifth, passes whose rows follow
    each other faster than a table can stop.
    """
    target, time_s = continued(columns.target_deg), columns.time_s
    if time_s is None or target.size < LEAST_ROWS:
        return None
    passes = passes_of(columns)
    rounding_s = _rounding(time_s)
    speeds = [_steady_speed(target[rows], time_s[rows], rounding_s) for rows in passes]
    near = [
        rows.stop - rows.start >= LEAST_ROWS
        and (
            float(np.median(np.abs(np.diff(target[rows])))) <= MOVING_STEP_DEG
            or _sampled_by_a_clock(target[rows], time_s[rows], rounding_s)
        )
        for rows in passes
    ]
    sampled_s = [
        float(np.median(np.diff(time_s[rows])))
        for rows, is_near in zip(passes, near, strict=True)
        if is_near
    ]
    near = [
        is_near or bool(speed and _in_the_steps_of(time_s[rows], sampled_s))
        for rows, speed, is_near in zip(passes, speeds, near, strict=True)
    ]
    far = np.array(
        [abs(speed) for speed, is_near in zip(speeds, near, strict=True) if speed and not is_near]
    )
    steady = far.size >= 2 and float(far.max()) > SPEED_RATIO * float(far.min())
    found = np.zeros(target.size)
    for rows, speed, is_near in zip(passes, speeds, near, strict=True):
        if is_near or (_cannot_stop(target[rows], time_s[rows]) and not (steady and speed)):
            angle = np.radians(target[rows])
            local = run_speeds(angle, time_s[rows], [(0, angle.size)], TARGET_NOISE_RAD)
            found[rows] = local.of(np.zeros(angle.size, dtype=np.int64), slice(None))
        elif steady and speed:
            found[rows] = speed
    return found if np.any(found != 0.0) else None


def _cannot_stop(target_deg: Float, time_s: Float) -> bool:
    """Tell whether the stations of a pass follow each other faster than a table can stop."""
    taken = np.diff(time_s)[np.diff(target_deg) != 0.0]
    return taken.size > 0 and 0.0 < float(np.median(taken)) < LEAST_STOP_S


def continued(target_deg: Float) -> Float:
    """Return the targets, (rows,), without steps of more than half a turn: a step from 345° to 0°
    goes on upwards, and one from 0° to 345° goes on downwards."""
    steps = np.diff(target_deg)
    far = np.abs(steps) > HALF_TURN_DEG
    if not far.any():
        return target_deg
    steps = np.where(far, steps - 360.0 * np.round(steps / 360.0), steps)
    return np.asarray(target_deg[0] + np.concatenate([[0.0], np.cumsum(steps)]))


def passes_of(columns: Reference) -> list[slice]:
    """Return the rows of each pass, between changes of run, cycle, direction, or sense of motion.

    In a file with targets within one turn, a pass also ends where the targets return to its first
    station.
    """
    target = continued(columns.target_deg)
    new = np.zeros(target.size, dtype=bool)
    new[0] = True
    for labels in (columns.run, columns.cycle, columns.direction):
        if labels is not None:
            new[1:] |= np.diff(labels) != 0
    if target is not columns.target_deg:
        _begin_after_a_turn(columns.target_deg, target, new)
    new[_turns(target, new)] = True
    bounds = [*np.flatnonzero(new).tolist(), target.size]
    return [slice(start, end) for start, end in pairwise(bounds)]


def _begin_after_a_turn(target_deg: Float, continued_deg: Float, new: NDArray[np.bool_]) -> None:
    """Mark the rows in ``new`` at which a pass has gone a whole turn, with a step from one end of
    the turn to the other (from 345° to 0°, or from 0° to 345°)."""
    step = np.abs(np.diff(continued_deg))
    turn = 360.0 - 0.5 * float(np.median(step))
    ends = np.flatnonzero(np.abs(np.diff(target_deg)) > HALF_TURN_DEG) + 1
    labelled = [*np.flatnonzero(new).tolist(), target_deg.size]
    for start, end in pairwise(labelled):
        first = start
        while True:
            # The pass has such a step between its first row and the row where it ends.
            after = ends[np.searchsorted(ends, first, side="right") :]
            if after.size == 0 or after[0] >= end:
                break
            first = _first_far(continued_deg, int(after[0]), end, continued_deg[first], turn)
            if first == end:
                break
            new[first] = True


def _first_far(angle_deg: Float, start: int, end: int, from_deg: float, way_deg: float) -> int:
    """Return the first row from ``start`` on that is ``way_deg`` or more away from ``from_deg``;
    ``end`` if there is none."""
    for low in range(start, end, BLOCK_ROWS):
        block = angle_deg[low : min(low + BLOCK_ROWS, end)]
        far = np.flatnonzero(np.abs(block - from_deg) >= way_deg)
        if far.size:
            return low + int(far[0])
    return end


def _turns(target_deg: Float, new: NDArray[np.bool_]) -> Integer:
    """Return the rows at which a pass begins because the targets change their sense.

    ``new``: True where labels begin a pass, (rows,). A single step in the opposite sense returns to
    the first station, where a new pass begins. If the table turns back at a station that is read
    twice, the new pass begins with the second reading.
    """
    sense = np.sign(np.diff(target_deg))
    moves = np.flatnonzero(sense)
    before, after = moves[:-1], moves[1:]
    labelled = np.cumsum(new)
    turned = (sense[before] != sense[after]) & (labelled[after] == labelled[before])
    goes_on = ~np.append(turned[1:], False) & (after > before + 1)
    begins = turned & ~np.append(False, turned[:-1])[: turned.size]
    return np.asarray(np.where(goes_on, before + 2, after + 1)[begins])


def _rounding(time_s: Float) -> float:
    """Return the step of the last decimal with which a file states the times (rows,), seconds; 0 if
    they have more than FINEST_DECIMALS decimals."""
    for decimals in range(FINEST_DECIMALS + 1):
        steps = time_s * 10.0**decimals
        if float(np.abs(steps - np.round(steps)).max(initial=0.0)) < WHOLE_STEPS:
            return float(10.0**-decimals)
    return 0.0


def _are_even(taken_s: Float, expected_s: Float, rounding_s: float) -> bool:
    """Tell whether the times between rows equal the expected times within EVEN and the rounding of
    both time stamps; (rows − 1,).

    Coarse times of an operator's stops of different length could look even. Such times do not fit a
    line through the whole pass; even times deviate from the line only by their rounding, at most
    half a step.
    """
    usual_s = float(np.median(expected_s))
    coarse = rounding_s > FINE_ROUNDING * usual_s
    allowed_s = rounding_s if rounding_s <= MOST_ROUNDING * usual_s else 0.0
    if not np.all(np.abs(taken_s - expected_s) < EVEN * expected_s + allowed_s):
        return False
    if not coarse or allowed_s == 0.0:
        return True
    way = np.concatenate([[0.0], np.cumsum(expected_s)])
    late_s = np.concatenate([[0.0], np.cumsum(taken_s)]) - way
    late_s = late_s - np.polyval(np.polyfit(way, late_s, 1), way)
    return float(np.abs(late_s).max()) < 0.5 * rounding_s + EVEN * usual_s


def _sampled_by_a_clock(target_deg: Float, time_s: Float, rounding_s: float) -> bool:
    """Tell whether a clock sampled the pass, which then has no stops.

    The times of such a pass are even, and its distances change smoothly and by more than a fifth.
    """
    way, taken = np.abs(np.diff(target_deg)), np.diff(time_s)
    usual_s, usual_deg = float(np.median(taken)), float(np.median(way))
    if usual_s <= 0.0 or not _are_even(taken, np.full(taken.size, usual_s), rounding_s):
        return False
    smooth = float(np.median(np.abs(np.diff(way)))) < SMOOTH * usual_deg
    low, high = np.quantile(way, [0.1, 0.9])
    return smooth and float(high) > SPEED_RATIO * float(low)


def _in_the_steps_of(time_s: Float, sampled_s: list[float]) -> bool:
    """Tell whether the median time step equals one of ``sampled_s``, of passes in motion."""
    step_s = float(np.median(np.diff(time_s)))
    return any(abs(step_s / one - 1.0) < EVEN for one in sampled_s if one > 0.0)


def _steady_speed(target_deg: Float, time_s: Float, rounding_s: float) -> float | None:
    """Return the speed of a pass, rad/s, if its times are proportional to its distances, otherwise
    None. ``rounding_s``: rounding step of the times."""
    if target_deg.size < LEAST_ROWS:
        return None
    way, taken = np.diff(target_deg), np.diff(time_s)
    if np.any(taken <= 0.0) or np.any(way == 0.0):
        return None
    # The whole pass gives the mean speed, which the rounding of single times does not shift.
    pace = float(target_deg[-1] - target_deg[0]) / float(time_s[-1] - time_s[0])
    if pace == 0.0 or np.any(way / pace <= 0.0):
        return None
    return float(np.radians(pace)) if _are_even(taken, way / pace, rounding_s) else None
