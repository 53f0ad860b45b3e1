"""Tests of the Allan deviation against figures published in NIST SP 1065, and against its behaviour
for known noise."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.metrology.allan import overlapping_allan_deviation

LENGTHS = (1, 10, 100)
PUBLISHED = (2.922319e-01, 9.159953e-02, 3.241343e-02)
"""Overlapping Allan deviation at averaging factors 1, 10 and 100, from the test suite of 1000
points in NIST SP 1065."""


def nist_points() -> np.ndarray:
    """Return the 1000 points of the generator that SP 1065 gives."""
    state, points = 1234567890, []
    for _ in range(1000):
        points.append(state / 2147483647)
        state = 16807 * state % 2147483647
    return np.array(points)


def test_the_published_figures() -> None:
    deviation, pairs = overlapping_allan_deviation(nist_points(), LENGTHS)
    np.testing.assert_allclose(deviation, PUBLISHED, rtol=5e-7)
    assert pairs.tolist() == [999, 981, 801]


def test_a_drift_rises_with_the_length() -> None:
    """A drift of D per reading has exactly the Allan deviation D·m/√2, where m is the averaging
    factor."""
    deviation, _ = overlapping_allan_deviation(0.3 * np.arange(100.0), LENGTHS[:2])
    np.testing.assert_allclose(deviation, 0.3 * np.array([1, 10]) / np.sqrt(2), rtol=1e-12)


def test_a_missing_reading_takes_its_pairs_away_and_no_others() -> None:
    values = nist_points()
    values[600] = np.nan
    deviation, pairs = overlapping_allan_deviation(values, [3, 400])
    means = [values[k : k + 3].mean() for k in range(998)]
    steps = np.array([means[k + 3] - means[k] for k in range(995)])
    kept = np.isfinite(steps)
    assert pairs.tolist() == [int(kept.sum()), 0]
    assert deviation[0] == pytest.approx(np.sqrt(np.mean(steps[kept] ** 2) / 2), rel=1e-12)
    assert np.isnan(deviation[1])


@pytest.mark.parametrize("lengths", [[0], [1.5]])
def test_lengths_are_whole(lengths: list[float]) -> None:
    with pytest.raises(ValueError, match="whole numbers"):
        overlapping_allan_deviation(np.arange(9.0), lengths)
