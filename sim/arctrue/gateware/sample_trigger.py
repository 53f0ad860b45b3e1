"""Bit-true model of ``rtl/sampler/sample_trigger.vhd``: which clocks are sampled."""

from __future__ import annotations

import enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.generated import number_formats

_DIVISION_CLOCKS = number_formats.POSITION_WIDTH - 1


class _Grid(enum.Enum):
    IDLE = enum.auto()
    DIVIDE = enum.auto()
    WALK = enum.auto()
    TRACK = enum.auto()


def wrapped(value: int) -> int:
    """``value`` modulo 2**32 as a signed 32-bit number, like a position that wraps."""
    return (value + 2**31) % 2**32 - 2**31


class SampleTrigger:
    """The trigger, clock by clock; one instance holds the state of one entity."""

    def __init__(self) -> None:
        """Start in the state after a reset."""
        self._elapsed = 1
        self._state = _Grid.IDLE
        self._clocks_left = 0
        self._step = self._found = 0
        self._lower = self._upper = self._middle = 0
        self._fresh = True

    def clock(
        self, enable: bool, mode: int, sample_period: int, angle_step: int, turn_position: int
    ) -> bool:
        """Whether this clock is sampled. The VHDL's ``trigger`` is high one clock later.

        ``sample_period`` in clocks, ``angle_step`` and ``turn_position`` (signed, 32 bits) in
        counts; ``mode`` 0 equal time, 1 equal angle.
        """
        in_time = self._equal_time(sample_period)
        in_angle = self._equal_angle(angle_step, turn_position)
        if not enable or mode == 1:
            in_time = False
            self._elapsed = 1
        if not enable or mode == 0 or (self._state != _Grid.IDLE and angle_step != self._step):
            in_angle = False
            self._state = _Grid.IDLE
        return in_time or in_angle

    def _equal_time(self, sample_period: int) -> bool:
        if self._elapsed >= sample_period:
            self._elapsed = 1
            return True
        self._elapsed += 1
        return False

    def _equal_angle(self, angle_step: int, position: int) -> bool:
        match self._state:
            case _Grid.IDLE:
                self._step = angle_step
                if angle_step:
                    self._found = position - position % angle_step
                    # The division, and two clocks that set the multiples around it.
                    self._clocks_left = _DIVISION_CLOCKS + 2
                    self._state = _Grid.DIVIDE
            case _Grid.DIVIDE:
                self._clocks_left -= 1
                if self._clocks_left == 0:
                    self._lower = wrapped(self._found)
                    self._upper = wrapped(self._found + self._step)
                    self._state = _Grid.WALK
            case _Grid.WALK:
                self._walk(position)
            case _Grid.TRACK:
                return self._track(position)
        return False

    def _walk(self, position: int) -> None:
        self._fresh = True
        if wrapped(position - self._upper) >= 0:
            self._lower, self._upper = self._upper, wrapped(self._upper + self._step)
        elif position == self._lower:
            self._middle, self._lower = self._lower, wrapped(self._lower - self._step)
            self._fresh = False
            self._state = _Grid.TRACK
        elif wrapped(self._lower - position) >= 0:
            self._lower, self._upper = wrapped(self._lower - self._step), self._lower
        else:
            self._state = _Grid.TRACK

    def _track(self, position: int) -> bool:
        if wrapped(position - self._upper) >= 0:
            if not self._fresh:
                self._lower = self._middle
            self._middle, self._upper = self._upper, wrapped(self._upper + self._step)
        elif wrapped(self._lower - position) >= 0:
            if not self._fresh:
                self._upper = self._middle
            self._middle, self._lower = self._lower, wrapped(self._lower - self._step)
        else:
            return False
        self._fresh = False
        return True


def sample_trigger(
    turn_position: ArrayLike,
    *,
    enable: ArrayLike = True,
    mode: ArrayLike = 0,
    sample_period: ArrayLike = 100_000,
    angle_step: ArrayLike = 0,
) -> NDArray[np.bool_]:
    """Which clocks are sampled: one boolean a clock, shape (clocks,).

    Every argument is one value a clock, or one for all clocks: ``turn_position`` of head 1 in
    counts (signed, 32 bits), ``mode`` 0 equal time or 1 equal angle, ``sample_period`` in clocks,
    ``angle_step`` in counts. Raises ValueError when the shapes do not fit.
    """
    columns = np.broadcast_arrays(
        np.asarray(enable, dtype=bool), mode, sample_period, angle_step, turn_position
    )
    trigger = SampleTrigger()
    rows = zip(*(np.atleast_1d(column).tolist() for column in columns), strict=True)
    return np.array([trigger.clock(*row) for row in rows], dtype=bool)
