"""Tests which orders the calibration applies, and which reason it states for each order that it
does not apply."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.calibration import CalibrationSettings, calibrate, least_squares, whole_turns
from arctrue.calibration.selection import select_orders, significance_factor
from arctrue.calibration.transfer_function import noise_gain, transfer_function

from .synthetic import COUNTS, Disc, capture_of, set_of, turn_angles

ALPHA = np.radians(33.0)


def estimate_of(disc: Disc, most: int, noise: float = 0.1, seed: int = 5, samples: int = 4000):
    heads = disc.heads(turn_angles(samples), noise, np.random.default_rng(seed))
    turns = whole_turns(capture_of([heads]), COUNTS, None, most)
    return least_squares(turns, COUNTS, ALPHA, np.arange(1, most + 1))[0]


def test_significant_orders_are_applied() -> None:
    disc = Disc({1: (95.0, 0.4), 3: (0.5, 1.0), 8: (0.2, 2.0), 11: (1.5, 0.0)})
    # As a function of the reading, the error also has (95″)²/2 = 0.022″ of order 2.
    verdicts = select_orders(estimate_of(disc, 32), 32)
    assert [v.order for v in verdicts if v.applied] == [1, 2, 3, 8, 11]
    assert all(v.reason.startswith("not significant") for v in verdicts if not v.applied)
    assert all(v.reason == "" for v in verdicts if v.applied)


def test_noise_alone_applies_nothing() -> None:
    applied = sum(
        v.applied
        for seed in range(40)
        for v in select_orders(estimate_of(Disc({}), 32, seed=seed, samples=1000), 32)
    )
    # A set contains a false order with a probability of 5 %. In 40 sets 2 false orders are
    # expected; more than 6 occur in one of 200 such tests.
    assert applied <= 6


def test_unseen_and_loud_orders_are_not_applied() -> None:
    disc = Disc({1: (95.0, 0.4), 11: (2.0, 0.0), 119: (1.0, 1.0), 120: (5.0, 1.0)})
    estimate = estimate_of(disc, 121)
    by_order = {v.order: v for v in select_orders(estimate, 32)}
    assert by_order[120].reason.startswith("cannot be seen")
    assert by_order[11].applied
    assert by_order[119].applied
    strict = {v.order: v for v in select_orders(estimate, 32, gain_limit=10.0)}
    assert not strict[11].applied
    assert strict[11].reason == "noise gain above 10"


def test_largest_orders_have_the_lanes() -> None:
    disc = Disc({n: (10.0 / n, 0.1 * n) for n in range(1, 9)})
    verdicts = select_orders(estimate_of(disc, 8), 4)
    assert [v.order for v in verdicts if v.applied] == [1, 2, 3, 4]
    assert verdicts[6].reason.startswith("no lane free")


def test_coefficients_hold_the_applied_orders() -> None:
    disc = Disc({1: (95.0, 0.4), 3: (0.5, 1.0), 32: (0.4, 1.0)})
    heads = disc.heads(turn_angles(), 0.1, np.random.default_rng(1))
    found = calibrate(set_of(disc, capture_of([heads])), CalibrationSettings(lanes=8))
    used = found.coefficients.amplitudes != 0
    assert found.coefficients.lanes == 8
    assert found.coefficients.orders[used].tolist() == [1, 2, 3, 32]
    arcsec = found.coefficients.amplitudes_counts[used] * 1_296_000 / COUNTS
    assert arcsec == pytest.approx([95.0, 0.022, 0.5, 0.4], abs=0.01)


def test_significance_factor_by_simulation() -> None:
    """The factor is the quantile of noise amplitudes divided by their estimated uncertainty, which
    comes from 96 exponentially distributed spectral lines."""
    random = np.random.default_rng(3)
    amplitude = np.hypot(*random.normal(size=(2, 400_000)))
    u = np.sqrt(random.gamma(96, 1.0 / 96, 400_000))
    # A false-alarm probability of 5 % over 5 orders is 1 % for each order; 400,000 draws determine
    # it with a standard deviation of 0.016 %.
    share = np.mean(amplitude > significance_factor(5) * u)
    assert share == pytest.approx(0.01, abs=0.0006)


def test_transfer_function() -> None:
    orders = np.array([1, 11, 60, 120, 240])
    direct = 1.0 / (np.exp(1j * orders[:3] * ALPHA) - 1.0)
    assert transfer_function(orders, ALPHA)[:3] == pytest.approx(direct)
    assert (transfer_function(orders, ALPHA)[3:] == 0.0).all()
    assert np.isinf(noise_gain(orders, ALPHA)[3:]).all()
    assert noise_gain(11, ALPHA) == pytest.approx(19.1, abs=0.1)
