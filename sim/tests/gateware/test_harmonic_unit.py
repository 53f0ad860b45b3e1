"""Compares the models of harmonic_unit and harmonic_lane with float64 and with exact integers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arctrue.gateware.harmonic_lane import harmonic_lane, lane_cosine
from arctrue.gateware.harmonic_unit import harmonic_unit
from arctrue.generated.number_formats import PAIR_FRACTION, PAIR_WIDTH, PHASE_WIDTH
from arctrue.studies.paper.appendix import cosine_bound

TURN = 1 << PHASE_WIDTH
LARGEST = 2**24


def some(seed: int, lanes: int, angles: int = 400) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    phases = rng.integers(0, TURN, (angles, lanes), dtype=np.int32)
    return phases, rng.integers(-LARGEST, LARGEST, lanes)


@pytest.mark.parametrize("lanes", [1, 2, 3, 32, 64])
def test_pair_sums_are_terms_of_equation_9(lanes: int) -> None:
    phases, amplitudes = some(lanes, lanes)
    sums = harmonic_unit(phases, amplitudes)
    assert sums.shape == (400, (lanes + 1) // 2)
    terms = amplitudes * 2.0**-11 * np.cos(phases * (2 * math.pi / TURN))
    bounds = np.abs(amplitudes) * 2.0**-11 * cosine_bound()
    exact = np.add.reduceat(terms, range(0, lanes, 2), axis=1)
    bound = np.add.reduceat(bounds, range(0, lanes, 2))
    assert np.all(np.abs(sums * 2.0**-PAIR_FRACTION - exact) <= bound)


@pytest.mark.parametrize(("width", "iterations"), [(18, 16), (14, 12), (22, 20)])
def test_pair_sums_hold_every_bit_of_the_products(width: int, iterations: int) -> None:
    phases, amplitudes = some(3, 5)
    cosines = lane_cosine(phases, width, iterations).tolist()
    sums = harmonic_unit(phases, amplitudes, width, iterations).tolist()
    for cosine, found in zip(cosines, sums, strict=True):
        products = [c * a for c, a in zip(cosine, amplitudes.tolist(), strict=True)]
        pairs = [products[0] + products[1], products[2] + products[3], products[4]]
        # A product has width + 9 fraction bits, a pair sum has 27.
        assert found == [(pair << 20) >> (width + 2) for pair in pairs]


def test_lane_adds_its_partner() -> None:
    phases, amplitudes = some(4, 2)
    first = harmonic_lane(phases[:, 0], amplitudes[0])
    both = harmonic_lane(phases[:, 1], amplitudes[1], partner=first)
    assert both.tolist() == harmonic_unit(phases, amplitudes)[:, 0].tolist()


def test_largest_pair_fits() -> None:
    """The largest pair sum fits into s15.27: with amplitudes at the end of their format and cosines
    of ±1 it is near 2¹⁴ counts."""
    phases = np.array([[0, 0], [TURN // 2, TURN // 2]], dtype=np.int32)
    sums = harmonic_unit(phases, [-LARGEST, -LARGEST])[:, 0]
    assert np.all(np.abs(sums) < 2 ** (PAIR_WIDTH - 1))
    assert np.all(np.abs(np.abs(sums) * 2.0**-PAIR_FRACTION - 2**14) <= 2)


def test_amplitudes_that_change_with_the_angle() -> None:
    phases, _ = some(5, 3, angles=20)
    amplitudes = np.random.default_rng(8).integers(-LARGEST, LARGEST, (20, 3))
    sums = harmonic_unit(phases, amplitudes)
    for index in range(20):
        alone = harmonic_unit(phases[index : index + 1], amplitudes[index])
        assert sums[index].tolist() == alone[0].tolist()


def test_inputs_are_left_alone() -> None:
    phases, amplitudes = some(6, 4)
    copies = phases.copy(), amplitudes.copy()
    harmonic_unit(phases, amplitudes)
    assert np.array_equal(phases, copies[0])
    assert np.array_equal(amplitudes, copies[1])
