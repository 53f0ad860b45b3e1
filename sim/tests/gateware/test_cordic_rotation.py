"""Tests the CORDIC's cosine against the bounds of the paper's appendix, and tests its constants."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from arctrue.gateware.cordic_rotation import (
    cordic_rotation,
    rotation_tables,
    start_radius,
)
from arctrue.gateware.harmonic_lane import lane_cosine
from arctrue.generated.number_formats import (
    CORDIC_ITERATIONS,
    COSINE_WIDTH,
    PHASE_WIDTH,
    TABULATED_ITERATIONS,
    Y_SAVED_WIDTH,
)
from arctrue.report.cordic_error import cosine_error, draw_cordic_error, swept_phases
from arctrue.studies.paper.appendix import cosine_bound

TURN = 1 << PHASE_WIDTH


def test_every_phase_of_20_bits_stays_within_the_bound() -> None:
    """The largest error of the cosine is below (A.1) + (A.5) as printed, and near the value in the
    header of the entity."""
    phase = swept_phases(20)
    assert phase.size == 2**20
    bound = cosine_bound()
    assert bound == pytest.approx(1.18e-4, abs=5e-7)
    error = np.abs(cosine_error(phase))
    assert error.max() <= bound
    assert 5.2e-5 < error.max() < 5.4e-5


def test_every_phase_of_24_bits_stays_within_the_bound() -> None:
    largest = 0.0
    for start in range(0, TURN, 1 << 20):
        phase = np.arange(start, start + (1 << 20), dtype=np.int32)
        largest = max(largest, float(np.abs(cosine_error(phase)).max()))
    assert largest <= cosine_bound()
    assert largest < 5.6e-5


@pytest.mark.parametrize(("width", "iterations"), [(14, 12), (20, 18), (18, 12), (18, 20), (8, 8)])
def test_other_widths_and_iterations_stay_within_their_bounds(width: int, iterations: int) -> None:
    error = cosine_error(swept_phases(18) + 5, bits=width, iterations=iterations)
    assert np.abs(error).max() <= cosine_bound(width, iterations)


def test_rotation_against_equation_10_in_fractions() -> None:
    """The model differs from exact arithmetic with the same directions of rotation only by the
    roundings of nine iterations."""
    tables = rotation_tables(COSINE_WIDTH, CORDIC_ITERATIONS)
    folded = np.arange(0, TURN // 4, 49_999, dtype=np.int32)
    found = cordic_rotation(folded)
    for angle, cosine in zip(folded.tolist(), found.tolist(), strict=True):
        z = angle >> 3
        x, y = Fraction(start_radius()), Fraction(0)
        for i in range(CORDIC_ITERATIONS):
            d = -1 if z < 0 else 1
            x, y = x - d * y / 2**i, y + d * x / 2**i
            z -= d * tables.steps[i]
        # Each rounding of x, one of the constant and one per iteration, adds half a unit. A
        # rounding of y is half a unit of 2⁴, which iteration i multiplies by 2⁻ⁱ: the roundings of
        # the constant and of iterations 7 to 9 add less than a quarter of a unit. The bound has one
        # unit for these roundings and for the iterations that do not change y.
        assert (
            abs(cosine - x * 2**COSINE_WIDTH)
            < 0.5 * (1 + CORDIC_ITERATIONS - TABULATED_ITERATIONS) + 1
        )


def test_constants() -> None:
    """The start value fulfils equation (11), and the arctangents are right to half a unit of 2⁻²¹
    turn."""
    tables = rotation_tables(COSINE_WIDTH, CORDIC_ITERATIONS)
    assert start_radius() == pytest.approx(0.60725, abs=5e-6)
    assert tables.angle_fraction == 21
    for i, step in enumerate(tables.steps):
        assert abs(step / 2**21 * 2 * math.pi - math.atan2(1, 2**i)) <= math.pi / 2**21
    # Each tabulated vector has the length that the first iterations give.
    gain = math.prod(math.hypot(1, 2.0**-i) for i in range(TABULATED_ITERATIONS))
    assert np.allclose(
        np.hypot(tables.x, tables.y * 2**Y_SAVED_WIDTH) / 2**COSINE_WIDTH,
        start_radius() * gain,
        atol=2.0 ** (Y_SAVED_WIDTH - COSINE_WIDTH),
    )
    assert np.unique(tables.x).size == tables.x.size == 64


def test_symmetry() -> None:
    """Phases p and −p − 1 (all bits complemented) have the same cosine; a phase half a turn further
    has exactly the negative cosine."""
    phase = np.arange(0, TURN, 1009, dtype=np.int32)
    cosine = lane_cosine(phase)
    assert np.array_equal(lane_cosine(TURN - 1 - phase), cosine)
    assert np.array_equal(lane_cosine((phase + TURN // 2) % TURN), -cosine)
    one = 1 << (COSINE_WIDTH - 2)
    assert (
        np.abs(
            lane_cosine(np.array([0, TURN // 4, TURN // 2]).astype(np.int32)) - (one, 0, -one)
        ).max()
        <= 2
    )


@pytest.mark.parametrize(("width", "iterations"), [(7, 16), (25, 16), (18, 7), (18, 25)])
def test_what_is_not_built_is_refused(width: int, iterations: int) -> None:
    with pytest.raises(ValueError, match="the gateware has 8 to 24 bits"):
        lane_cosine(np.zeros(1, dtype=np.int32), width, iterations)


def test_picture(tmp_path: Path) -> None:
    """``draw_cordic_error`` draws the picture and returns the largest error of the sweep in the
    picture."""
    picture = tmp_path / "reports" / "error.png"
    phase = swept_phases(12)
    largest = draw_cordic_error(picture, (phase, lane_cosine(phase)))
    assert largest == np.abs(cosine_error(swept_phases())).max()
    assert picture.read_bytes().startswith(b"\x89PNG")
