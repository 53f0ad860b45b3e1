"""Finds the wraps of an angle (restarts at the end of a turn), its passes in one direction and its
cycles, from the angles alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement.wraps import ROUNDED_TURN

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

LARGEST_REVERSAL_TURNS = 1.0 / 360.0
"""Reversal, in turns, that ends a pass for any range of the angle: one degree, a chosen value."""
REVERSAL_SHARE = 0.01
"""Reversal that ends a pass, as a share of the whole range, if this is less than one degree; a
smaller reversal counts as noise. A chosen value."""
LEAST_ROWS_A_PASS = 4
"""Smallest mean number of rows in a pass; if passes are shorter, the rows are not in order of
angle."""
FULL_TURN = 1.0 - 1e-6
"""Motion, in turns, after which a new cycle begins; 1e-6 allows for rounding of the angles."""


@dataclass(frozen=True)
class Pass:
    """A pass: the rows from ``start`` to before ``end``, during which the table moves in one
    direction, +1 or −1."""

    start: int
    end: int
    direction: int


def without_jumps(angle_turns: Float) -> tuple[Float, int]:
    """Continue angles (n,) past the end of each turn, and count the wraps.

    The angles are changed only if all of them lie within one turn, apart from rounding; each step
    between two rows is then taken as the shorter way round.
    """
    if angle_turns.size < 2 or float(np.ptp(angle_turns)) > ROUNDED_TURN:
        return angle_turns, 0
    turns = -np.round(np.diff(angle_turns))
    wraps = int(np.count_nonzero(turns))
    if not wraps:
        return angle_turns, 0
    return angle_turns + np.concatenate(([0.0], np.cumsum(turns))), wraps


def passes(angle_turns: Float) -> list[Pass]:
    """Divide all rows into passes; return [] without motion or with a mean under 4 rows per pass.

    A pass ends where the angle turns back by more than 1 % of the whole range or more than one
    degree, whichever is less. The row at the turning point belongs to the pass that ends there;
    if the table stands there for several rows, the first half of them belongs to this pass.
    """
    if angle_turns.size < 2:
        return []
    least = min(REVERSAL_SHARE * float(np.ptp(angle_turns)), LARGEST_REVERSAL_TURNS)
    if least <= 0.0:
        return []
    # A pass can end only at a row where the angle changes its direction.
    moving = np.flatnonzero(np.diff(angle_turns))
    sign = np.sign(np.diff(angle_turns)[moving])
    turning = moving[1:][sign[1:] != sign[:-1]]
    corners = [0, *turning.tolist(), angle_turns.size - 1]
    found: list[Pass] = []
    start, extreme, direction = 0, 0, 0
    for corner in corners:
        way = float(angle_turns[corner] - angle_turns[extreme])
        if direction == 0:
            if abs(way) > least:
                direction, extreme = int(np.sign(way)), corner
        elif way * direction >= 0.0:
            extreme = corner
        elif abs(way) > least:
            end = _middle_of_stand(angle_turns, extreme)
            found.append(Pass(start, end, direction))
            start, extreme, direction = end, corner, -direction
    found.append(Pass(start, angle_turns.size, direction))
    return found if angle_turns.size >= LEAST_ROWS_A_PASS * len(found) else []


def _middle_of_stand(angle_turns: Float, extreme: int) -> int:
    """Return the row after the first half of the rows in which the table stands at the turning
    point."""
    first = last = extreme
    while first > 0 and angle_turns[first - 1] == angle_turns[extreme]:
        first -= 1
    while last + 1 < angle_turns.size and angle_turns[last + 1] == angle_turns[extreme]:
        last += 1
    return first + (last - first + 2) // 2


def cycles(angle_turns: Float, found: list[Pass]) -> Integer:
    """Return the number of each row's cycle, from 0: a cycle is a pass and its return, or one turn
    of a long pass."""
    numbers = np.zeros(angle_turns.size, dtype=np.int64)
    if not found:
        return numbers
    both = len({item.direction for item in found}) == 2
    pair = -1
    offset = 0
    for item in found:
        if item.direction == found[0].direction:
            pair += 1
            if pair:
                offset = int(numbers[: item.start].max()) + 1
        way = np.abs(angle_turns[item.start : item.end] - angle_turns[item.start])
        # A row at the end of a turn begins a new cycle, because a station at 360° repeats the
        # station at 0°.
        whole = np.floor(way / FULL_TURN).astype(np.int64)
        if both and way.max(initial=0.0) <= 1.0 + 1e-6:
            whole[:] = 0
        numbers[item.start : item.end] = offset + whole
    return numbers
