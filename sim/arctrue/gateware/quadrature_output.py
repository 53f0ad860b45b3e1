"""Models ``rtl/quadrature_output/quadrature_output.vhd`` bit by bit, clock by clock, without the
inversion and the exchange of its pins."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

LATENCY = 6
"""Number of clocks from a position to its edge, if no rule delays the edge."""

_A_OF_PHASE = (0, 1, 1, 0)
_B_OF_PHASE = (0, 0, 1, 1)
_TURNS = range(-2, 2)
_Z_COUNTS = (1, 2, 4, 4)
# near_lag does not contain the steps that were decided in the last three clocks. It is computed
# from an output of two clocks ago, and a step changes the output one clock after its decision.
_STEPS_UNDER_WAY = 3


def _wrapped(value: int) -> int:
    return (value + 2**31) % 2**32 - 2**31


@dataclass(frozen=True)
class OutputInputs:
    """Inputs of the quadrature output; each is one value per clock, or one value for all clocks."""

    corrected_position: ArrayLike
    """Corrected position over many turns, counts, signed, 32 bits."""
    corrected_angle: ArrayLike
    """Corrected angle, counts, 0 to counts_per_rev - 1."""
    counts_per_rev: ArrayLike
    """Counts per turn."""
    minimum_spacing: ArrayLike = 1
    """Smallest permitted spacing of output edges, clocks."""
    referenced: ArrayLike = True
    """Whether corrected_angle counts from an index mark."""
    phase_of_zero: ArrayLike = 0
    """Index of the levels (A, B) in the sequence 00, 10, 11, 01 at position 0 modulo 4."""
    z_gated: ArrayLike = False
    z_state: ArrayLike = 0
    """Index, in the sequence 00, 10, 11, 01, of the levels (A, B) at which a gated Z begins."""
    z_width: ArrayLike = 0
    """Code of the width of Z; 0: 1 count, 1: 2 counts, 2 and 3: 4 counts."""
    following_limit: ArrayLike = 2**16 - 1
    """Limit of the following error, counts."""
    enable: ArrayLike = True
    clear: ArrayLike = False
    reset: ArrayLike = False


@dataclass(frozen=True)
class OutputTrace:
    """Every output in every clock, shape (clocks + 1,).

    Element t is the output during clock t; in element 0, A and B have the levels from before the
    reset and the other outputs are 0. The last element follows the last input.
    """

    a: NDArray[np.int64]
    b: NDArray[np.int64]
    z: NDArray[np.int64]
    following_error: NDArray[np.int64]
    """Following error, counts."""
    cannot_keep_up: NDArray[np.int64]


class _ZSettings(NamedTuple):
    gated: bool
    state: int
    width: int

    def is_high(self, behind_zero: int, phase: int) -> bool:
        """Tell whether Z is high, given the count after the zero and the phase of (A, B)."""
        counts = _Z_COUNTS[self.width]
        if not self.gated:
            return 0 <= behind_zero < counts
        first = behind_zero - (phase - self.state) % 4
        return -2 <= first <= 1 and behind_zero - first < counts


class _Follower:
    """Registers of the entity; each method is one pipeline stage, and in each clock the last stage
    is called first."""

    def __init__(self) -> None:
        self.output = self.lag = self.near_lag = 0
        self.limit = self.turn_limit = 0
        self.turns_are_less = False
        self.phase = self.phase_then = 0
        self.spacing = 0
        self.pins = [0, 0, 0]
        # Angle minus position, the turn, and whether a zero is known, from one, two and three
        # clocks ago.
        self.references = [(0, 0, False)] * 3
        self.behind_zero = 0
        # Settings that are sampled one clock before they take effect.
        self.z_before = _ZSettings(False, 0, 0)
        self.phase_of_zero = 0
        self.restart()

    def restart(self) -> None:
        """Set the registers that a reset changes."""
        self.following = self.too_far = False
        self.enabled = (False, False)
        self.steps = [0] * _STEPS_UNDER_WAY
        self.direction = 1
        self.may_step = True
        self.pins[2] = 0
        self.following_error = 0
        self.cannot_keep_up = 0

    def show(self, clear: bool, following_limit: int, turn: int, z: _ZSettings) -> None:
        """Update the pins, the following error and its flag."""
        self.pins[:2] = _A_OF_PHASE[self.phase_then], _B_OF_PHASE[self.phase_then]
        if any(self.enabled):
            reference, turn_then, referenced = self.references[2]
            zero = reference + self.output_then
            behind = [_wrapped(zero + turns * turn_then) for turns in _TURNS]
            if z.gated and not self.z_before.gated:
                referenced = False
            of_clock = self.z_before if z.gated else z
            high = any(of_clock.is_high(n, self.phase_then) for n in behind)
            self.pins[2] = int(referenced and high)
        self.z_before = z
        self.cannot_keep_up = int(self.too_far or (self.cannot_keep_up and not clear))
        self.following_error = 0
        self.too_far = False
        if self.following and self.enabled[0]:
            self.following_error = self.lag
            self.too_far = abs(self.lag) > self.limit
        # The smaller limit is valid; the gateware compares the two limits one clock earlier.
        self.limit = self.turn_limit if self.turns_are_less else following_limit
        self.turns_are_less = following_limit > self.turn_limit
        self.turn_limit = 2 * turn - 1

    def decide(self, minimum_spacing: int, reset: bool) -> int:
        """Return the step that the output makes in the next clock: -1, 0 or 1."""
        remaining = self.near_lag - sum(self.steps)
        step = 0
        if self.following and all(self.enabled) and self.may_step and not reset:
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

    def move(self, position: int, phase_of_zero: int) -> None:
        """Make the step that was decided one clock ago. While the output does not follow, set it to
        the position near ``position`` at which A and B have their present levels."""
        self.near_lag = min(max(self.lag, -8), 7)
        self.phase_then, self.output_then = self.phase, self.output
        self.lag = _wrapped(position - self.output)
        if self.following:
            self.phase = (self.phase + self.steps[0]) % 4
            self.output = _wrapped(self.output + self.steps[0])
        else:
            to_phase = (self.phase - self.phase_of_zero - position + 2) % 4 - 2
            self.output = _wrapped(position + to_phase)
        self.phase_of_zero = phase_of_zero

    def refer(self, position: int, angle: int, turn: int, referenced: bool) -> None:
        """Store the difference between position and angle, which defines the zero; the turn is
        stored one clock later."""
        (reference, _, was_referenced), of_turn, _ = self.references
        now = (_wrapped(angle - position), 0, referenced)
        self.references = [now, (reference, turn, was_referenced), of_turn]


def quadrature_output(inputs: OutputInputs, held_phase: int = 0) -> OutputTrace:
    """Run the output over all clocks of ``inputs``, starting from a reset at the first position.

    ``held_phase``: index of the levels (A, B) in 00, 10, 11, 01 before this reset, which keeps
    these levels; 0 at power-up. Raises ValueError if the shapes of the inputs do not fit.
    """
    names = [field.name for field in fields(inputs)]
    columns = np.broadcast_arrays(*(np.atleast_1d(getattr(inputs, name)) for name in names))
    follower = _Follower()
    follower.output = follower.output_then = int(columns[0][0])
    follower.phase = follower.phase_then = held_phase
    follower.pins[:2] = _A_OF_PHASE[held_phase], _B_OF_PHASE[held_phase]
    follower.phase_of_zero = int(columns[5][0])
    follower.z_before = _ZSettings(*(column[0].item() for column in columns[6:9]))
    outputs = np.zeros((columns[0].size + 1, 5), dtype=np.int64)
    outputs[0, :2] = follower.pins[:2]
    rows = zip(*(column.tolist() for column in columns), strict=True)
    for clock, row in enumerate(rows):
        position, angle, turn, spacing, referenced, phase_of_zero, *z = row[:-4]
        limit, enable, clear, reset = row[-4:]
        cannot_keep_up = follower.cannot_keep_up
        follower.show(clear, limit, turn, _ZSettings(*z))
        step = follower.decide(spacing, reset)
        follower.move(position, phase_of_zero)
        follower.refer(position, angle, turn, referenced)
        following = follower.following
        follower.steps = [step, *follower.steps[:-1]] if following else [0] * _STEPS_UNDER_WAY
        follower.enabled = (following, follower.enabled[0])
        follower.following = bool(enable and not cannot_keep_up)
        if reset:
            follower.restart()
        outputs[clock + 1] = (*follower.pins, follower.following_error, follower.cannot_keep_up)
    return OutputTrace(*outputs.T)
