"""Tests that TrendWatch has the stated rate of false alarms and reports drifts of orders with their
size."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from arctrue.metrology.trend import Trend, TrendWatch

RNG_SEED = 5


def telemetry_of(values: np.ndarray) -> list[list[float]]:
    """Return orders 1, 2, … in the form of the telemetry, in which the phase is that of cos(nθ +
    φ)."""
    return [[n + 1, float(abs(v)), float(-np.angle(v)), 0.1, 1] for n, v in enumerate(values)]


def test_noise_alone_alarms_as_often_as_stated() -> None:
    """With noise alone, TrendWatch raises alarms as often as stated.

    5 % of the fitted lines may raise an alarm; the number of alarms in 250 lines must lie in the
    99.9 % range of the binomial distribution.
    """
    rng = np.random.default_rng(RNG_SEED)
    lines, alarms = 250, 0
    for _ in range(lines):
        watch = TrendWatch(block_turns=1, blocks=8, false_alarms=0.05)
        values = rng.normal(size=(8, 4)) + 1j * rng.normal(size=(8, 4))
        alarms += any(watch.add(turn, telemetry_of(row)) for turn, row in enumerate(values))
    low, high = stats.binom.interval(0.999, lines, 0.05)
    assert low <= alarms <= high


def test_a_drift_is_reported_with_its_size() -> None:
    """TrendWatch reports a drift with its size: the cosine and sine of order 2 change by 0.01″ and
    −0.02″ per turn, and the noise of a turn is 0.1″."""
    rng = np.random.default_rng(RNG_SEED)
    watch, found = TrendWatch(), []
    for turn in range(128):
        noise = 0.1 * (rng.normal(size=3) + 1j * rng.normal(size=3))
        moved = np.array([5.0, 1.0 + (0.01 - 0.02j) * turn, 0.0])
        found += watch.add(turn, telemetry_of(moved + noise))
    (trend,) = found
    assert (trend.order, trend.turns) == (2, 112)
    # The line is fitted to 8 means of 16 turns, each with a standard uncertainty of 0.025″.
    expected_u = 0.1 / 4 / np.sqrt(8) / np.std(np.arange(8)) * 7
    assert trend.u_arcsec == pytest.approx(expected_u, rel=0.6)
    assert trend.cosine_arcsec == pytest.approx(1.12, abs=4 * expected_u)
    assert trend.sine_arcsec == pytest.approx(-2.24, abs=4 * expected_u)
    assert str(trend).startswith("order 2 changes by 2.5″ in 112 turns")


def test_what_does_not_matter_is_not_reported() -> None:
    watch = TrendWatch(3.0)
    assert not any(watch.add(turn, telemetry_of(np.array([0.02 * turn]))) for turn in range(300))


def steady_drift(watch: TrendWatch, turns: range) -> list[Trend]:
    rng = np.random.default_rng(RNG_SEED)
    found = []
    for turn in turns:
        found += watch.add(turn, telemetry_of(np.array([0.5 * turn + rng.normal(0, 0.1)])))
    return found


def test_refused_and_repeated_turns_are_passed_over_and_a_new_start_begins_anew() -> None:
    watch = TrendWatch(block_turns=2, blocks=4)
    assert watch.add(0, []) == []
    assert steady_drift(watch, range(1, 8)) == []
    assert watch.add(7, telemetry_of(np.array([99.0]))) == []
    assert len(steady_drift(watch, range(8, 9))) == 1
    # The device starts again and counts from 1: the watch fits no line across the start.
    assert steady_drift(watch, range(1, 8)) == []
    assert len(steady_drift(watch, range(8, 9))) == 1


def test_two_means_make_no_line() -> None:
    with pytest.raises(ValueError, match="three blocks"):
        TrendWatch(blocks=2)
