"""Tests that the firmware assigns the latched angles to the right turn near the end of a turn.

The test computes the registers from exact counts over many turns. The core counts the turns of the
uncorrected reading that enters the lanes; the corrected angle appears up to 43 clocks later (29 + 2
(FOLD - 1) with FOLD = 8) and lies in another turn if the correction moves it past 0.
"""

from __future__ import annotations

from fractions import Fraction
from math import floor
from typing import Any

import numpy as np
import pytest
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import ModelCore, address, bit

COUNTS = 1 << 24
CORRECTION_ONE = 2048
MOST_AGE_CLOCKS = 43
SURE_COUNTS = 200
"""Distance of a reading from 0 at which the turn must be certain. The table moves by at most 150
counts in the 150 clocks of the reads."""


class TurningCore(ModelCore):
    """A core whose table turns at constant speed: each read takes ten clocks, and a read of the
    snapshot's time latches all angles in one clock."""

    def __init__(self, start: int, speed: Fraction, correction: int, age: int, ahead: int) -> None:
        super().__init__()
        self.set("version", 0x000800)
        self.set("capability", 2 | bit("capability", "real_orders"))
        self.start, self.speed, self.correction, self.age = start, speed, correction, age
        self.head1_ahead = ahead
        self.clock = 0
        self.corrected = 0
        self.head1 = 0

    def reading(self, clock: int) -> int:
        """Return the reading of a clock in counts over all turns."""
        return self.start + floor(self.speed * clock)

    def read(self, context: Any, offset: int) -> int:
        self.clock += 10
        if offset == address("turn_number"):
            return (self.reading(self.clock) // COUNTS) & 0xFFFF_FFFF
        if offset == address("snapshot.time"):
            self.head1 = self.reading(self.clock) + self.head1_ahead
            rounded = floor(Fraction(self.correction, CORRECTION_ONE) + Fraction(1, 2))
            self.corrected = self.reading(self.clock - self.age) - rounded
            self.set("snapshot.head1_angle", self.head1 % COUNTS)
            self.set("snapshot.corrected_angle", self.corrected % COUNTS)
            self.set("snapshot.correction", self.correction)
        return super().read(context, offset)


def assigned(core: TurningCore) -> tuple[bool, Any]:
    ffi, library = firmware()
    place = ffi.new("struct core_turn_place *")
    return library.core_turn_place(core.access, COUNTS, place), place


@pytest.mark.parametrize("with_mean", [False, True])
def test_turns_near_the_end_of_a_turn(with_mean: bool) -> None:
    """The turns of the corrected angle and of head 1 are right if the firmware calls them certain,
    and it calls them certain for every reading farther than SURE_COUNTS from 0.

    ``with_mean``: the output is the mean of the heads. The correction then also contains the
    ``mean_term`` of the gateware, up to 2¹⁸ counts. The core may count the turns of another head
    than head 1, so that the turn of head 1 is not compared.
    """
    random = np.random.default_rng(7)
    most = 2**18 if with_mean else 4_000
    certain = 0
    for _ in range(3_000):
        near = int(random.integers(-2 * most, 2 * most) // random.choice([1, 30]))
        core = TurningCore(
            start=int(random.integers(-3, 4)) * COUNTS + near,
            speed=Fraction(int(random.integers(-100, 101)), 100),
            correction=int(random.integers(-most, most) * CORRECTION_ONE // random.choice([1, 30])),
            age=int(random.integers(0, MOST_AGE_CLOCKS + 1)),
            ahead=int(random.integers(0, COUNTS)) if with_mean else 0,
        )
        sure, place = assigned(core)
        if abs(near) > SURE_COUNTS:
            assert sure
        if sure:
            certain += 1
            assert place.turn == core.corrected // COUNTS
            assert place.angle == core.corrected % COUNTS
            if not with_mean:
                assert place.head1_turn == core.head1 // COUNTS
                assert place.head1_angle == core.head1 % COUNTS
    assert certain > 1_000


def test_a_reading_at_the_end_and_a_corrected_angle_at_the_start() -> None:
    """The reading is 1,400 counts before the end of turn 4, and the correction of -1,900 counts
    moves the corrected angle to count 500 of turn 5."""
    core = TurningCore(5 * COUNTS - 1_400, Fraction(0), -1_900 * CORRECTION_ONE, 0, 0)
    sure, place = assigned(core)
    assert (sure, place.turn, place.angle, place.head1_turn) == (True, 5, 500, 4)
