"""Models modes 0 and 1 of ``rtl/sampler/sample_trigger.vhd`` bit by bit; the entity selects the
clocks that are sampled."""

from __future__ import annotations

import enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.generated import number_formats

_SEARCH_CLOCKS = number_formats.POSITION_WIDTH - 1 + 3
"""Number of clocks after which the multiples of the angle step are known: a division and three
further clocks."""


class _Grid(enum.Enum):
    IDLE = enum.auto()
    SEARCH = enum.auto()
    START = enum.auto()
    TRACK = enum.auto()
    LOST = enum.auto()


def wrapped(value: int) -> int:
    """Return ``value`` modulo 2**32 as a signed 32-bit number; positions wrap in this way."""
    return (value + 2**31) % 2**32 - 2**31


class SampleTrigger:
    """One sample trigger, clock by clock; an instance holds its state."""

    def __init__(self) -> None:
        """Set the state after a reset."""
        self._elapsed = 1
        self._state = _Grid.IDLE
        self._clocks_left = 0
        self._step = 0
        self._before = self._unwrapped = 0
        self._on_multiple = False
        self._fresh = True
        self._left_by = 0
        self._zero_before = 0

    def clock(
        self,
        enable: bool,
        mode: int,
        sample_period: int,
        angle_step: int,
        turn_position: int,
        zero_moved: int = 0,
    ) -> bool:
        """Tell whether this clock is sampled.

        The VHDL's ``trigger`` is high one clock later. ``sample_period`` in clocks, ``angle_step``
        and ``turn_position`` (signed, 32 bits) in counts; ``mode`` 0 equal time, 1 equal angle;
        ``zero_moved`` toggles at the first position that counts from a new zero. Raises ValueError
        if the position moves by more than one count although the zero is unchanged, because no
        decoder gives such a position. The trigger checks this only while it determines or uses the
        multiples of ``angle_step``.
        """
        in_time = self._equal_time(sample_period)
        changes, jumps = angle_step != self._step, zero_moved != self._zero_before
        self._zero_before = zero_moved
        if jumps:
            self._state = _Grid.LOST if angle_step else _Grid.IDLE
        in_angle = self._equal_angle(angle_step, turn_position)
        if jumps:
            # In the next clock the angle step therefore counts as changed, and the trigger
            # determines its multiples again.
            self._step = 0
        if not enable or mode == 1:
            in_time = False
            self._elapsed = 1
        if not enable or mode == 0 or changes:
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
        move = wrapped(position - self._before)
        self._before = position
        if self._state == _Grid.LOST:
            return False
        if self._state == _Grid.IDLE:
            self._step = angle_step
            self._unwrapped = position
            self._clocks_left = _SEARCH_CLOCKS
            if angle_step:
                self._state = _Grid.SEARCH
            return False
        if abs(move) > 1:
            raise ValueError(
                f"turn_position moves by {move} counts in one clock; a decoder's moves by 1 at most"
            )
        stood_on_multiple = self._unwrapped % self._step == 0
        self._unwrapped += move
        match self._state:
            case _Grid.SEARCH:
                self._clocks_left -= 1
                if self._clocks_left == 0:
                    self._state = _Grid.START
            case _Grid.START:
                self._on_multiple = stood_on_multiple
                self._fresh = not stood_on_multiple
                self._follow(move)
                self._state = _Grid.TRACK
            case _Grid.TRACK:
                return self._follow(move)
        return False

    def _follow(self, move: int) -> bool:
        """Tell whether ``move`` reached a multiple of the step that is not the multiple reached
        before."""
        if move == 0:
            return False
        left_multiple = self._on_multiple
        self._on_multiple = self._unwrapped % self._step == 0
        is_another = self._fresh or left_multiple or self._left_by == move
        if left_multiple:
            self._left_by = move
        if self._on_multiple:
            self._fresh = False
        return self._on_multiple and is_another


def sample_trigger(
    turn_position: ArrayLike,
    *,
    enable: ArrayLike = True,
    mode: ArrayLike = 0,
    sample_period: ArrayLike = 100_000,
    angle_step: ArrayLike = 0,
    zero_moved: ArrayLike = 0,
) -> NDArray[np.bool_]:
    """Return for each clock whether it is sampled, shape (clocks,).

    Every argument is one value per clock, or one for all clocks: ``turn_position`` of head 1 in
    counts (signed, 32 bits), ``mode`` (0 equal time, 1 equal angle), ``sample_period`` in clocks,
    ``angle_step`` in counts. ``zero_moved`` is the level that toggles when the position counts from
    a new zero. Raises ValueError if the shapes do not fit, or if the position jumps without a new
    zero while equal angles are sampled.
    """
    columns = np.broadcast_arrays(
        np.asarray(enable, dtype=bool),
        mode,
        sample_period,
        angle_step,
        turn_position,
        zero_moved,
    )
    trigger = SampleTrigger()
    rows = zip(*(np.atleast_1d(column).tolist() for column in columns), strict=True)
    return np.array([trigger.clock(*row) for row in rows], dtype=bool)
