"""Tests of the counts that the heads of a moving table show."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.table import (
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    RotaryTable,
    TableState,
    two_heads,
)

ARCSEC = np.deg2rad(1 / 3600)
TABLE = RotaryTable(
    two_heads(),
    (DiscEccentricity(40e-6, 1.0), GraduationHarmonics((3,), (2 * ARCSEC,), (0.5,))),
    noise_rad=0.1 * ARCSEC,
)


def test_a_turn_at_the_papers_speed_has_12000_steps_of_108_arcsec() -> None:
    state = Motion.steady(np.deg2rad(30.0), 12.0).state(np.arange(12_000) / 1000.0)
    random = np.random.default_rng(0)
    first, second = (TABLE.counts(head, state, random) for head in (0, 1))
    step_arcsec = np.diff(first) * TABLE.count_rad / ARCSEC
    # A step is 108″. The tolerance contains 0.08″ of rounding, 0.08″ for the slope of the
    # eccentricity, and five σ of the difference of two readings.
    assert np.abs(step_arcsec - 108).max() < 0.08 + 0.08 + 5 * np.sqrt(2) * 0.1
    clean = TABLE.reading_rad(1, TableState.at_rest(state.angle_rad)) / TABLE.count_rad
    scatter = second + 0.5 - clean
    expected = np.hypot(0.1 * ARCSEC / TABLE.count_rad, np.sqrt(1 / 12))
    assert scatter.std() == pytest.approx(expected, rel=0.04)
    assert abs(scatter.mean()) < 5 * expected / np.sqrt(scatter.size)


def test_no_random_source_no_noise() -> None:
    state = Motion.steady(1.0, 1.0).state(np.linspace(0.0, 1.0, 101))
    np.testing.assert_array_equal(TABLE.counts(0, state), TABLE.counts(0, state))
    noisy = TABLE.counts(0, state, np.random.default_rng(0))
    assert np.any(noisy != TABLE.counts(0, state))
