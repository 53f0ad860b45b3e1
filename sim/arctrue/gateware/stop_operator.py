"""Models the entity ``stop_operator``, which determines the direction of motion with hysteresis."""

from __future__ import annotations

from typing import Final

from arctrue.generated.number_formats import STOP_FRACTION, STOP_STEP_MAX

STOP_LATENCY: Final = 7
"""Number of clocks from a position to its place."""


class StopOperator:
    """Two stop operators that begin at the opposite ends −width and width; the place is known when
    both agree.

    The place follows the count and stops at ±width; place / width is the direction. Each call of
    ``move`` processes one reading; the model omits the latency of the entity.
    """

    def __init__(self, width: int, dead_zone: int = 0) -> None:
        """Store ``width`` in 1/16 count and ``dead_zone`` in counts."""
        self.width = width
        self._dead_zone = dead_zone
        self._slack = 0
        self._low, self._high = -width, width
        self._before: int | None = None

    def move(self, position: int, put_back: int = 0) -> tuple[int, bool]:
        """Process a reading in counts; return the place in 1/16 count and whether it is known."""
        count = position - put_back
        step = 0 if self._before is None else count - self._before
        self._before = count
        moved = self._slack + (step if abs(step) <= STOP_STEP_MAX else 0)
        self._slack = min(max(moved, 0), self._dead_zone)
        way = (moved - self._slack) << STOP_FRACTION
        self._low = min(max(self._low + way, -self.width), self.width)
        self._high = min(max(self._high + way, -self.width), self.width)
        return self._high, self._low == self._high
