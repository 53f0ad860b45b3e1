"""Tests the model of table_rotation: compares its cosine with float64 (the error must not exceed
the stated bound) and with exact products."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from arctrue.gateware.harmonic_lane import lane_cosine
from arctrue.gateware.table_rotation import (
    DIGITS_WIDTH,
    OFFSET_WIDTH,
    ROW_FRACTION,
    error_bound,
    table_rotation,
    tangent_table,
)
from arctrue.generated.number_formats import (
    COSINE_ADDRESS_WIDTH,
    COSINE_FRACTION,
    COSINE_SLOPE_FRACTION,
    COSINE_VALUE_FRACTION,
    COSINE_WIDTH,
    PHASE_WIDTH,
)
from arctrue.studies.paper.appendix import cosine_bound

TURN = 1 << PHASE_WIDTH
BLOCK = 1 << 20
SWEPT = 2.1e-5
"""Largest error over all phases, found by a sweep; the header of the entity states it."""


def test_every_phase_stays_within_the_bound() -> None:
    """The error of the cosine, compared with numpy, stays within the bound of the entity's header
    for all 2**24 phases."""
    largest = 0.0
    for start in range(0, TURN, BLOCK):
        phase = np.arange(start, start + BLOCK, dtype=np.int32)
        cosine = lane_cosine(phase, rotation="table") * 2.0**-COSINE_FRACTION
        error = np.abs(cosine - np.cos(phase * (2 * np.pi / TURN)))
        largest = max(largest, float(error.max()))
    assert largest <= error_bound() < 2.7e-5
    assert largest <= SWEPT
    # The error is less than half of the CORDIC's largest error in a sweep, 5.4e-5; the bound is
    # less than a quarter of the paper's bound for the CORDIC, 1.18e-4.
    assert largest < 5.4e-5 / 2
    assert error_bound() < cosine_bound() / 4


def test_rows_are_a_product() -> None:
    """The exact result is value − slope × position in the interval. The model's result is above it
    by less than 2**-ROW_FRACTION, the last bit of the rows of adders, or below it by less than
    2⁻¹⁸, the last bit of the result."""
    table = tangent_table()
    folded = np.arange(0, TURN // 4, 4_999, dtype=np.int32)
    unit = Fraction(1, 2**ROW_FRACTION)
    for angle, found in zip(folded.tolist(), table_rotation(folded).tolist(), strict=True):
        address, offset = divmod(angle, 1 << OFFSET_WIDTH)
        place = offset >> (OFFSET_WIDTH - DIGITS_WIDTH)
        turns = Fraction(place, 2 ** (PHASE_WIDTH - OFFSET_WIDTH + DIGITS_WIDTH))
        product = Fraction(int(table.slopes[address]), 2**COSINE_SLOPE_FRACTION) * turns
        exact = Fraction(int(table.values[address]), 2**COSINE_VALUE_FRACTION) - product
        below = exact - Fraction(found, 2**COSINE_WIDTH)
        assert -unit < below < Fraction(1, 2**COSINE_WIDTH)


def test_lines_meet_their_neighbours() -> None:
    """At the border of two intervals, the values of both lines differ by at most twice the bound of
    the error."""
    last = np.arange(1, 1 << COSINE_ADDRESS_WIDTH, dtype=np.int32) << OFFSET_WIDTH
    step = table_rotation(last - 1) - table_rotation(last)
    assert np.abs(step).max() * 2.0**-COSINE_WIDTH <= 2 * error_bound()


def test_symmetry() -> None:
    """Phases p and −p − 1 (all bits complemented) have the same cosine; a phase half a turn further
    has exactly the negative cosine."""
    phase = np.arange(0, TURN, 1009, dtype=np.int32)
    cosine = lane_cosine(phase, rotation="table")
    assert np.array_equal(lane_cosine(TURN - 1 - phase, rotation="table"), cosine)
    assert np.array_equal(lane_cosine((phase + TURN // 2) % TURN, rotation="table"), -cosine)


@pytest.mark.parametrize(("width", "iterations"), [(20, 16), (18, 18)])
def test_what_is_not_built_is_refused(width: int, iterations: int) -> None:
    with pytest.raises(ValueError, match="ROTATION = table is built for 18 bits"):
        lane_cosine(np.zeros(1, dtype=np.int32), width, iterations, "table")
