"""Tests that rounding, wrap and limit of the corrected angle equal exact arithmetic."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from arctrue.gateware.error_compensation import (
    add_pairs,
    correction_limit,
    error_compensation,
    subtract,
)
from arctrue.generated.number_formats import AMPLITUDE_FRACTION, PAIR_FRACTION

COUNT = 1 << PAIR_FRACTION


@pytest.mark.parametrize("counts_per_rev", [4, 5, 1000, 2**24 - 1, 2**24])
def test_subtract_equals_exact_arithmetic(counts_per_rev: int) -> None:
    rng = np.random.default_rng(counts_per_rev)
    limit = correction_limit(counts_per_rev)
    total = np.concatenate(
        [
            rng.integers(-limit * COUNT, limit * COUNT + 1, 300),
            rng.integers(-2 * limit, 2 * limit + 1, 100) * (COUNT // 2),
        ]
    )
    angle = rng.integers(0, counts_per_rev, total.size)
    position = rng.integers(-(2**31), 2**31, total.size)
    found = subtract(angle, position, total, counts_per_rev)
    for index in range(total.size):
        exact = math.floor(Fraction(int(total[index]), COUNT) + Fraction(1, 2))
        assert found.corrected_angle[index] == (int(angle[index]) - exact) % counts_per_rev
        assert (found.corrected_position[index] - int(position[index]) + exact) % 2**32 == 0
        assert -(2**31) <= found.corrected_position[index] < 2**31
        assert found.correction[index] == math.floor(
            Fraction(int(total[index]), COUNT) * 2**AMPLITUDE_FRACTION
        )


@pytest.mark.parametrize("counts_per_rev", [4, 5, 6, 1000, 2**20, 2**20 + 2, 2**24])
def test_limit_is_below_half_a_turn(counts_per_rev: int) -> None:
    limit = correction_limit(counts_per_rev)
    assert 2 * limit < counts_per_rev
    assert limit < 2**19
    assert 2 * (limit + 1) >= counts_per_rev or limit == 2**19 - 1


def test_offset_is_aligned() -> None:
    pair_sums = np.array([[COUNT, -2 * COUNT], [3, 4]], dtype=np.int64)
    assert add_pairs(pair_sums, 5 << AMPLITUDE_FRACTION).tolist() == [4 * COUNT, 5 * COUNT + 7]


def test_switching_on_and_off_never_steps() -> None:
    """With a constant ε of 100 counts the position moves by at most one count per clock when
    `apply` changes."""
    clocks = 4000
    rate_units = 255
    apply = np.zeros(clocks, dtype=bool)
    apply[100:2000] = True
    ones = np.ones(clocks, dtype=np.int64)
    result = error_compensation(
        (100 * COUNT * ones)[:, np.newaxis],
        0,
        10 * ones,
        10 * ones,
        apply,
        np.zeros(clocks, dtype=bool),
        1000,
        rate_units << 24,
    )
    assert np.max(np.abs(np.diff(result.corrected_position))) == 1
    assert np.max(np.abs(np.diff(result.correction))) == rate_units
    assert result.corrected_position[99] == 10
    assert result.corrected_position[1999] == -90
    assert result.corrected_angle[1999] == 910
    assert result.corrected_position[-1] == 10
    assert not result.ramp_busy[-1]
