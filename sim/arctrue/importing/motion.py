"""What the motion itself says: wraps, passes in one direction, cycles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

LARGEST_REVERSAL_TURNS = 1.0 / 360.0
REVERSAL_SHARE = 0.01
"""A way back shorter than this share of the whole way, or than one degree, is noise."""
LEAST_ROWS_A_PASS = 4
"""Passes shorter than this on average are no motion: the rows are in no order of angle."""
FULL_TURN = 1.0 - 1e-6


@dataclass(frozen=True)
class Pass:
    """Rows ``start`` to ``end`` (not included) in one direction, +1 or −1."""

    start: int
    end: int
    direction: int


def without_jumps(angle_turns: Float) -> tuple[Float, int]:
    """Angles (n,) that go on past the turn, and how often they started anew at it.

    Only angles that all lie within one turn are taken to start anew there; each step is then the
    shorter way.
    """
    if angle_turns.size < 2 or float(np.ptp(angle_turns)) > 1.0:
        return angle_turns, 0
    turns = -np.round(np.diff(angle_turns))
    wraps = int(np.count_nonzero(turns))
    if not wraps:
        return angle_turns, 0
    return angle_turns + np.concatenate(([0.0], np.cumsum(turns))), wraps


def passes(angle_turns: Float) -> list[Pass]:
    """The passes in one direction, in order, which cover all rows; [] where there is no motion.

    A pass ends where the angle turns back by more than one degree or 1 % of the whole way. The row
    at the turning point belongs to the pass that reached it; of rows that stand there, the first
    half does.
    """
    if angle_turns.size < 2:
        return []
    least = min(REVERSAL_SHARE * float(np.ptp(angle_turns)), LARGEST_REVERSAL_TURNS)
    if least <= 0.0:
        return []
    # Only rows where the angle turns can end a pass.
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
    """The row after the first half of those that stand at the turning point."""
    first = last = extreme
    while first > 0 and angle_turns[first - 1] == angle_turns[extreme]:
        first -= 1
    while last + 1 < angle_turns.size and angle_turns[last + 1] == angle_turns[extreme]:
        last += 1
    return first + (last - first + 2) // 2


def cycles(angle_turns: Float, found: list[Pass]) -> Integer:
    """The cycle of each row, 0, 1, …: a pass with the way back, or a whole turn of a long pass."""
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
        # Up to a whole turn belongs to one cycle: a last station at 360° is the first one's.
        whole = np.floor(way / FULL_TURN).astype(np.int64)
        if both and way.max(initial=0.0) <= 1.0 + 1e-6:
            whole[:] = 0
        numbers[item.start : item.end] = offset + whole
    return numbers
