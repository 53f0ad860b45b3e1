"""Bit-true model of ``rtl/quadrature_output/quadrature_output.vhd``, clock by clock."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

LATENCY = 6
"""Clocks from a position to its edge, when nothing holds the edge back."""

SATURATION = 2**30
"""|following error| does not grow beyond this, counts."""

_A_OF_PHASE = (0, 1, 1, 0)
_B_OF_PHASE = (0, 0, 1, 1)
# The lag in hand is that of two clocks ago and lacks the steps since.
_STEPS_UNDER_WAY = 3


def _wrapped(value: int) -> int:
    return (value + 2**31) % 2**32 - 2**31


@dataclass(frozen=True)
class OutputInputs:
    """What the quadrature output sees, one value a clock or one for all clocks."""

    corrected_position: ArrayLike
    """Counts, multi-turn, signed, 32 bits."""
    corrected_angle: ArrayLike
    """Counts, 0 to counts_per_rev - 1."""
    counts_per_rev: ArrayLike
    """Counts."""
    minimum_spacing: ArrayLike = 1
    """Clocks."""
    referenced: ArrayLike = True
    """corrected_angle counts from an index mark."""
    following_limit: ArrayLike = 2**16 - 1
    """Counts."""
    enable: ArrayLike = True
    clear: ArrayLike = False
    reset: ArrayLike = False


@dataclass(frozen=True)
class OutputTrace:
    """Every output in every clock, shape (clocks + 1,).

    Element t is the output during clock t; the last one follows the last input.
    """

    a: NDArray[np.int64]
    b: NDArray[np.int64]
    z: NDArray[np.int64]
    following_error: NDArray[np.int64]
    """Counts."""
    cannot_keep_up: NDArray[np.int64]


class _Follower:
    """The registers of the entity; each method is one stage of it, last stage first."""

    def __init__(self) -> None:
        self.output = self.lag = self.near_lag = 0
        self.limit = self.turn_limit = 0
        self.turns_are_less = self.referenced_then = False
        self.angle_then = self.counts_per_rev_then = 0
        self.spacing = 0
        self.restart()

    def restart(self) -> None:
        """What a reset touches."""
        self.following = self.too_far = False
        self.enabled = (False, False)
        self.steps = [0] * _STEPS_UNDER_WAY
        self.direction = 1
        self.may_step = True
        self.phase = self.phase_then = 0
        self.pins = [0, 0, 0]
        self.following_error = 0
        self.cannot_keep_up = 0

    def show(self, clear: bool, following_limit: int, counts_per_rev: int) -> None:
        """Pins, following error and its flag."""
        self.pins[:2] = _A_OF_PHASE[self.phase_then], _B_OF_PHASE[self.phase_then]
        if any(self.enabled):
            turn = self.counts_per_rev_then
            zeros = (self.angle_then + turns * turn for turns in range(-2, 2))
            self.pins[2] = int(self.referenced_then and self.lag in zeros)
        self.cannot_keep_up = int(self.too_far or (self.cannot_keep_up and not clear))
        self.following_error = 0
        self.too_far = False
        if self.following and self.enabled[0]:
            self.following_error = min(max(self.lag, -SATURATION), SATURATION)
            self.too_far = abs(self.lag) > self.limit
        # Two settings, compared in a clock of their own.
        self.limit = self.turn_limit if self.turns_are_less else following_limit
        self.turns_are_less = following_limit > self.turn_limit
        self.turn_limit = 2 * counts_per_rev - 1

    def decide(self, minimum_spacing: int) -> int:
        """The step that the output takes in the next clock: -1, 0 or 1."""
        remaining = self.near_lag - sum(self.steps)
        step = 0
        if self.following and all(self.enabled) and self.may_step:
            needed = 1 if remaining * self.direction > 0 else 2
            if abs(remaining) >= needed:
                step = 1 if remaining > 0 else -1
        if step:
            self.direction = step
            self.spacing = minimum_spacing
            self.may_step = minimum_spacing <= 1
        elif not self.may_step:
            self.may_step = self.spacing <= 2
            self.spacing -= 1
        return step

    def move(self, position: int) -> None:
        """Take the step decided one clock ago, or track the position while disabled."""
        lag = self.lag
        self.near_lag = min(max(lag, -8), 7)
        self.phase_then = self.phase
        self.lag = _wrapped(position - self.output)
        if not self.following:
            self.output = position
            return
        self.phase = (self.phase + self.steps[0]) % 4
        if lag >= SATURATION:
            self.output = _wrapped(position - SATURATION)
        elif lag < -SATURATION:
            self.output = _wrapped(position + SATURATION)
        else:
            self.output = _wrapped(self.output + self.steps[0])


def quadrature_output(inputs: OutputInputs) -> OutputTrace:
    """Run the output over all clocks of ``inputs``, from a reset at the first position on.

    Raises ValueError when the shapes of the inputs do not fit.
    """
    names = [field.name for field in fields(inputs)]
    columns = np.broadcast_arrays(*(np.atleast_1d(getattr(inputs, name)) for name in names))
    follower = _Follower()
    follower.output = int(columns[0][0])
    outputs = np.zeros((columns[0].size + 1, 5), dtype=np.int64)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    for clock, row in enumerate(rows):
        position, angle, turn, spacing, referenced, limit, enable, clear, reset = row
        follower.show(clear, limit, turn)
        step = follower.decide(spacing)
        follower.move(position)
        follower.angle_then, follower.counts_per_rev_then = angle, turn
        follower.referenced_then = bool(referenced)
        following = follower.following
        follower.steps = [step, *follower.steps[:-1]] if following else [0] * _STEPS_UNDER_WAY
        follower.enabled = (following, follower.enabled[0])
        follower.following = bool(enable)
        if reset:
            follower.restart()
        outputs[clock + 1] = (*follower.pins, follower.following_error, follower.cannot_keep_up)
    return OutputTrace(*outputs.T)
