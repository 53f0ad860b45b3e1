"""Tests that the mean's model follows its equation exactly and suppresses motion of the axis."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from arctrue.gateware.mean_set import WEIGHT_ONE, MeanSet
from arctrue.gateware.weighted_mean import TERM_LSB_COUNTS, weighted_mean, whole_readings

COUNTS = 2**24
PLACES_DEG = np.array([0.0, 33.0, 162.5, 300.5])


def mean_angle(angles: np.ndarray, mean: MeanSet, counts: int) -> np.ndarray:
    """Return θ in counts for E = 0: the carrier's reading without the fraction of its offset, minus
    the term of the mean."""
    whole = whole_readings(angles, mean, counts)
    return whole[:, mean.carrier - 1] - weighted_mean(whole, mean, counts).term * TERM_LSB_COUNTS


def weights_for(places_deg: np.ndarray) -> tuple[int, ...]:
    """Return the rounded weights with Σw = 1, Σw·e^{jβ} = 0 and the smallest Σw²; the first weight
    absorbs the rounding of all weights."""
    places = np.radians(places_deg)
    rows = np.array([np.ones(places.size), np.cos(places), np.sin(places)])
    words = np.rint(np.linalg.pinv(rows) @ [1.0, 0.0, 0.0] * WEIGHT_ONE).astype(int)
    words[0] += WEIGHT_ONE - words.sum()
    return tuple(words.tolist())


@pytest.mark.parametrize("carrier", [1, 2, 3, 4])
def test_it_is_the_weighted_mean_of_the_readings(carrier: int) -> None:
    """The model equals the mean in exact fractions, because its term is not rounded."""
    rng = np.random.default_rng(carrier)
    mean = MeanSet((20000, 45536, -30000, 30000), (3, 1600 * 16 + 5, 15, 4097 * 16), carrier)
    true = rng.integers(2000, COUNTS - 9000, 500)
    angles = true[:, np.newaxis] + rng.integers(-900, 900, (500, 4))
    found = mean_angle(angles, mean, COUNTS)
    for row, theta in zip(angles.tolist(), found.tolist(), strict=True):
        expected = sum(
            Fraction(weight, WEIGHT_ONE) * (reading - Fraction(offset, 16))
            for weight, reading, offset in zip(mean.weights, row, mean.offsets, strict=True)
        )
        away = (Fraction(theta) - expected) % COUNTS
        assert away == 0


def test_the_same_angle_for_every_carrier_over_the_turns_end() -> None:
    """Whichever head is the carrier, the mean makes no step where the readings of the heads wrap,
    at different angles."""
    weights, offsets = (16384,) * 4, (8, 777 * 16, 5, 16 * (COUNTS - 900) + 9)
    true = np.arange(-3000, 3000, 7)
    whole = np.array(offsets) // 16
    angles = (true[:, np.newaxis] + whole + np.array([0, 40, -25, 700])) % COUNTS
    found = [mean_angle(angles, MeanSet(weights, offsets, s), COUNTS) for s in (1, 2, 3, 4)]
    expected = true + (0 + 40 - 25 + 700) / 4 - (8 + 0 + 5 + 9) / 64
    for theta in found:
        away = (theta - expected + COUNTS / 2) % COUNTS - COUNTS / 2
        assert np.abs(away).max() == 0.0


def test_a_translation_of_the_axis_is_not_in_the_mean() -> None:
    """The mean does not contain a motion of the axis by 2 µm, by which head 1 alone is wrong.

    The heads stand at 0, 33, 162.5 and 300.5° on a radius of 52 mm. The mean contains only two
    errors: half a count times the weight for the rounding of each head, and 2⁻¹⁷ of the motion for
    the rounding of each weight.
    """
    weights = weights_for(PLACES_DEG)
    mean = MeanSet(weights, (0,) * 4)
    turn = np.linspace(0.0, 2.0 * np.pi, 2000, endpoint=False)
    motion_counts = 2e-6 / 52e-3 / (2.0 * np.pi) * COUNTS
    places = np.radians(PLACES_DEG)
    moved = motion_counts * np.sin(3.0 * turn[:, np.newaxis] + 0.3 - places)
    true = np.arange(2000) * (COUNTS // 4000) + COUNTS // 8
    angles = np.rint(true[:, np.newaxis] + moved).astype(int)
    left = mean_angle(angles, mean, COUNTS) - true
    bound = sum(abs(w) for w in weights) / WEIGHT_ONE * 0.5 + 4 * 2**-17 * motion_counts
    assert np.abs(left).max() <= bound
    assert np.abs(angles[:, 0] - true).max() > 60 * bound, "head 1 alone is wrong by the motion"


def test_a_difference_beyond_the_format_is_limited_and_said() -> None:
    mean = MeanSet((32768, 32768), (0, 0))
    readings = np.array([[0, 65_535], [0, 65_536], [65_536, 0], [65_537, 0]])
    found = weighted_mean(readings, mean, COUNTS)
    assert found.limited.tolist() == [False, True, False, True]
    assert (found.term * TERM_LSB_COUNTS).tolist() == [-32767.5, -32767.96875, 32768.0, 32768.0]
    unused = MeanSet((65536, 0), (0, 0), 1, 2)
    assert not weighted_mean(readings, unused, COUNTS).limited.any()
