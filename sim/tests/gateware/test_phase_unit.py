"""Compares the model's phases with exact integer arithmetic, for every order and many numbers of
counts per turn."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from arctrue.gateware.lane_words import phase_step
from arctrue.gateware.phase_lane import phase_lane
from arctrue.gateware.phase_unit import phase_unit
from arctrue.generated.number_formats import PHASE_WIDTH

TURN = 1 << PHASE_WIDTH
# The error of the phase step K is up to half a unit, 2⁻⁴⁹ turn per count, and an angle has less
# than 2²⁴ counts. The rounding of the phase adds ROUNDING.
STEP_ERROR = Fraction(1, 2**25)
ROUNDING = Fraction(1, 2**25)
COUNTS = [4, 5, 7, 1000, 65_535, 65_536, 1_000_003, 12_345_677, 2**24 - 3, 2**24 - 1, 2**24]


def distance(phase: Fraction) -> Fraction:
    """Return the distance of a phase, in turns, from the nearest whole turn."""
    part = phase % 1
    return min(part, 1 - part)


@pytest.mark.parametrize("counts_per_rev", COUNTS)
def test_phase_against_fractions(counts_per_rev: int) -> None:
    rng = np.random.default_rng(counts_per_rev)
    orders = [0, 1, 2, 11, 109, 16_384, 32_767, 32_768, 65_534, 65_535]
    orders += rng.integers(0, 65_536, 30).tolist()
    angles = {0, 1, counts_per_rev // 2, counts_per_rev - 1}
    angles |= set(rng.integers(0, counts_per_rev, 30).tolist())
    for order in orders:
        step = phase_step(order, counts_per_rev)
        for angle in sorted(angles):
            offset = int(rng.integers(0, TURN))
            exact = Fraction(order * angle, counts_per_rev) + Fraction(offset, TURN)
            phase = int(phase_lane(angle, step, offset))
            assert 0 <= phase < TURN
            assert distance(Fraction(phase, TURN) - exact) < STEP_ERROR + ROUNDING


@pytest.mark.parametrize("counts_per_rev", COUNTS)
def test_every_order_at_the_end_of_the_turn(counts_per_rev: int) -> None:
    """For all 65,536 orders the phase at the largest angle is right, before its rounding in units
    of 2⁻⁴⁸ turn and after it."""
    angle = counts_per_rev - 1
    steps = [phase_step(order, counts_per_rev) for order in range(65_536)]
    offset = 123_456
    found = phase_lane(angle, np.array(steps, dtype=np.uint64), offset)
    for order, step, phase in zip(range(65_536), steps, found.tolist(), strict=True):
        turns = angle * step
        # Check |θ·K − n·θ·2⁴⁸ / counts_per_rev| < 2²³, modulo a turn, with both sides multiplied by
        # counts_per_rev.
        error = (turns * counts_per_rev - order * angle * 2**48) % (counts_per_rev * 2**48)
        error = min(error, counts_per_rev * 2**48 - error)
        assert error < counts_per_rev * 2**23
        # The phase is rounded only once, half up.
        assert phase == ((turns + offset * 2**24 + 2**23) // 2**24) % TURN


def test_lanes_are_apart() -> None:
    rng = np.random.default_rng(5)
    angles = rng.integers(0, 2**24, 50)
    steps = rng.integers(0, 2**48, 7)
    offsets = rng.integers(0, TURN, 7)
    phases = phase_unit(angles, steps, offsets)
    assert phases.shape == (50, 7)
    for row, angle in zip(phases.tolist(), angles.tolist(), strict=True):
        words = zip(steps.tolist(), offsets.tolist(), strict=True)
        assert row == [(((a := angle * k) + 2**23 >> 24) + o) % TURN for k, o in words], a


def test_words_that_change_with_the_angle() -> None:
    rng = np.random.default_rng(6)
    angles = rng.integers(0, 2**24, 20)
    steps = rng.integers(0, 2**48, (20, 3))
    offsets = rng.integers(0, TURN, (20, 3))
    phases = phase_unit(angles, steps, offsets)
    for index in range(20):
        alone = phase_unit(angles[index : index + 1], steps[index], offsets[index])
        assert phases[index].tolist() == alone[0].tolist()
