"""Tests that quantised coefficients are within half a unit of the given values, or are refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arctrue.gateware.coefficient_memory import CoefficientMemory
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.lane_words import phase_step


@pytest.mark.parametrize("counts_per_rev", [4, 1000, 65536, 12_345_677, 2**24])
@pytest.mark.filterwarnings("ignore:order")
def test_words_are_the_nearest(counts_per_rev: int) -> None:
    rng = np.random.default_rng(counts_per_rev)
    orders = rng.integers(0, 65536, 32)
    amplitudes = rng.uniform(-8191.9, 8191.9, 32)
    phases = rng.uniform(-20.0, 20.0, 32)
    found = Coefficients.from_harmonics(orders, amplitudes, phases, counts_per_rev)
    assert np.array_equal(found.orders, orders % counts_per_rev)
    assert np.max(np.abs(found.amplitudes_counts - amplitudes)) <= 2.0**-12
    difference = np.remainder(found.phases_rad - phases + math.pi, 2 * math.pi) - math.pi
    assert np.max(np.abs(difference)) <= 2 * math.pi * 2.0**-25 * (1 + 1e-6)


def test_phase_step_is_exact_at_every_order() -> None:
    """For five orders from 1 to 65,535 the error of the phase at the largest angle is below 2⁻²⁵
    turn: 2²⁴ counts times half a unit of the phase step, whose unit is 2⁻⁴⁸ turn per count."""
    counts_per_rev = 16_777_213
    for order in (1, 2, 109, 16_384, 65_535):
        angle = counts_per_rev - 1
        exact = order * angle % counts_per_rev / counts_per_rev
        formed = angle * phase_step(order, counts_per_rev) % 2**48 / 2**48
        assert abs(math.remainder(formed - exact, 1.0)) < 2.0**-25


@pytest.mark.parametrize("counts_per_rev", [5000, 2**24])
def test_error_is_equation_9(counts_per_rev: int) -> None:
    found = Coefficients.from_harmonics(
        [1, 7], [100.0, 3.5], [0.3, -2.0], counts_per_rev, 4, -12.25
    )
    angle = np.arange(0, counts_per_rev, counts_per_rev // 100)
    theta = 2 * math.pi * angle / counts_per_rev
    expected = 100 * np.cos(theta + 0.3) + 3.5 * np.cos(7 * theta - 2.0) - 12.25
    assert np.max(np.abs(found.error_counts(angle) - expected)) < 1e-3


@pytest.mark.parametrize(
    ("orders", "amplitudes", "phases", "counts_per_rev", "lanes", "message"),
    [
        ([1], [8192.0], [0.0], 2**24, 32, "amplitude of order 1: 8192 counts"),
        ([1], [-8192.0], [0.0], 2**24, 32, "amplitude of order 1"),
        ([1], [math.nan], [0.0], 2**24, 32, "amplitude of order 1: nan"),
        ([1], [1.0], [math.inf], 2**24, 32, "phase of order 1: inf"),
        ([65536], [1.0], [0.0], 2**24, 32, r"orders\[0\]: 65536"),
        ([-1], [1.0], [0.0], 2**24, 32, r"orders\[0\]: -1"),
        ([1.5], [1.0], [0.0], 2**24, 32, r"orders\[0\]: 1.5"),
        ([1, 2, 3], [1.0] * 3, [0.0] * 3, 2**24, 2, "3 harmonics do not fit into 2 lanes"),
        ([1, 2], [1.0], [0.0, 0.0], 2**24, 32, "2 orders, 1 amplitudes, 2 phases"),
        ([1], [1.0], [0.0], 3, 32, "counts_per_rev: 3"),
        ([1], [1.0], [0.0], 2**24 + 1, 32, "counts_per_rev"),
        ([1], [1.0], [0.0], 2**24, 65, "lanes: 65"),
        ([1], [1.0], [0.0], 2**24, 0, "lanes: 0"),
    ],
)
def test_what_the_formats_cannot_hold_is_refused(
    orders: list[int],
    amplitudes: list[float],
    phases: list[float],
    counts_per_rev: int,
    lanes: int,
    message: str,
) -> None:
    with pytest.raises(ValueError, match=message):
        Coefficients.from_harmonics(orders, amplitudes, phases, counts_per_rev, lanes)


def test_offset_outside_the_format_is_refused() -> None:
    with pytest.raises(ValueError, match="offset: 8192 counts"):
        Coefficients.from_harmonics([], [], [], 2**24, 4, 8192.0)


def test_warns_of_an_order_that_whole_counts_cannot_tell() -> None:
    with pytest.warns(UserWarning, match="order 500 is at or above half"):
        Coefficients.from_harmonics([500], [1.0], [0.0], 1000)


@pytest.mark.parametrize(
    ("field", "words", "message"),
    [
        ("phase_steps", [2**48], "phase_steps: lane 0"),
        ("phase_offsets", [2**24], "phase_offsets: lane 0"),
        ("amplitudes", [2**24], "amplitudes: lane 0"),
        ("amplitudes", [1, 2], "expected one phase step, phase offset and amplitude per lane"),
        ("amplitudes", [1.5], "expected integer words"),
    ],
)
def test_words_outside_the_formats_are_refused(field: str, words: list[int], message: str) -> None:
    lanes = {"phase_steps": [0], "phase_offsets": [0], "amplitudes": [0], field: words}
    with pytest.raises(ValueError, match=message):
        Coefficients(
            **{name: np.array(value) for name, value in lanes.items()}, offset=0, counts_per_rev=4
        )


def test_memory_returns_what_was_loaded() -> None:
    bank = Coefficients.from_harmonics([1, 16_384], [-5.0, 8191.5], [1.0, 2.0], 2**24, 3, -7.5)
    memory = CoefficientMemory(2**24, 3)
    assert memory.active == Coefficients.zero(2**24, 3)
    memory.load(bank)
    assert memory.active == bank
    memory.write(3, 99)
    assert memory.active == bank
    memory.swap()
    assert memory.active != bank
    assert memory.active.amplitudes[0] == 99
