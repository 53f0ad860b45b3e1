"""Models the entity ``table_speed``, which measures the travel of the table in a window of time."""

from __future__ import annotations

from typing import Final, NamedTuple

from arctrue.generated.number_formats import (
    CORRECTION_FRACTION,
    SPEED_BOUND_COUNTS,
    SPEED_LONGEST_BITS,
    SPEED_TREMBLE_COUNTS,
    SPEED_WINDOW_BITS,
)

SPEED_LATENCY: Final = 3
"""Number of clocks from a position to the speed for which this position was used."""
_ONE = 1 << CORRECTION_FRACTION
_TREMBLE = SPEED_TREMBLE_COUNTS * _ONE
_MOST_QUIET = SPEED_BOUND_COUNTS * _ONE


class Measured(NamedTuple):
    """Measurement at the end of a window; before the end it is an upper bound of the travel."""

    travel: int
    """Travel in 2⁻¹¹ count, without sign, 0 for less than 2 counts; it is one unit too small if the
    angle fell."""
    is_down: bool
    is_bound: bool
    elapsed: int
    """Clocks of the travel."""


class TableSpeed:
    """Measures the speed; each call of ``move`` processes one corrected reading. The model omits
    the latency of the entity."""

    def __init__(self, window: int = SPEED_WINDOW_BITS, longest: int = SPEED_LONGEST_BITS) -> None:
        """Begin without a window; ``window`` and ``longest`` are log2 of clocks."""
        self._window = 1 << window
        self._longest = (1 << longest) - 1
        self._period: int | None = None
        self._base = self._elapsed = 0
        self._anchored = self._passed = self._was_over = False
        self._is_down = False

    def move(self, position: int, correction: int) -> Measured | None:
        """Process ``position`` in counts, corrected by ``correction`` in 2⁻¹¹ count.

        Returns a measurement at the end of a window. If a window does not end, returns an upper
        bound each time a further window's length has passed. Otherwise returns None.
        """
        rounded = (correction + _ONE // 2) >> CORRECTION_FRACTION
        period = (position + rounded) // 4
        passes = self._period is not None and period != self._period
        self._period = period
        fine = (position + rounded) * _ONE - correction
        way = fine - self._base
        over = self._elapsed >= self._longest
        begins, found = False, None
        if passes and self._elapsed >= self._window and self._anchored and not over:
            self._is_down = way < 0
            size = ~way if way < 0 else way
            travel = 0 if size < _TREMBLE else size
            found = Measured(travel, self._is_down, False, self._elapsed)
            begins = True
        elif passes and not self._anchored:
            begins = True
        elif (over and not self._was_over) or self._is_tick():
            travel = 0 if over else _MOST_QUIET
            found = Measured(travel, self._is_down, True, self._elapsed)
            self._anchored = self._anchored and not over and not self._passed
        self._was_over = over
        if begins:
            self._base, self._elapsed = fine, 1
            self._anchored, self._passed = True, False
        elif not over:
            self._passed = self._passed or passes
            self._elapsed += 1
        return found

    def _is_tick(self) -> bool:
        return self._elapsed % self._window == 0 and self._elapsed >= 2 * self._window
