"""Model of the entity ``stop_operator``: the direction of motion with friction's hysteresis."""

from __future__ import annotations

from typing import Final

STOP_FRACTION: Final = 4
"""Width and place are in 1/16 count."""
STOP_LATENCY: Final = 7
"""Clocks from a position to the place."""
MOST_STEP: Final = 8
"""Counts in a clock; a larger step is no motion."""


class StopOperator:
    """Two stop operators from both ends, one reading a call (latency left out)."""

    def __init__(self, width: int, dead_zone: int = 0) -> None:
        """``width`` in 1/16 count, ``dead_zone`` in counts."""
        self.width = width
        self._dead_zone = dead_zone
        self._slack = 0
        self._low, self._high = -width, width
        self._before: int | None = None

    def move(self, position: int, put_back: int = 0) -> tuple[int, bool]:
        """Place in 1/16 count and whether it is known, after a reading in counts."""
        count = position - put_back
        step = 0 if self._before is None else count - self._before
        self._before = count
        moved = self._slack + (step if abs(step) <= MOST_STEP else 0)
        self._slack = min(max(moved, 0), self._dead_zone)
        way = (moved - self._slack) << STOP_FRACTION
        self._low = min(max(self._low + way, -self.width), self.width)
        self._high = min(max(self._high + way, -self.width), self.width)
        return self._high, self._low == self._high
