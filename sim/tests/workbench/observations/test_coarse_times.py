"""Tests of a log whose clock shows whole seconds only."""

from __future__ import annotations

import numpy as np
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.observations.coarse_times import spread


def test_spread_times_differ_from_the_true_ones_by_less_than_the_step_of_the_clock() -> None:
    random = np.random.default_rng(3)
    true = np.cumsum(random.uniform(0.2, 0.4, 500))
    for step in (0.01, 1.0, 2.5):
        stamps = np.floor(true / step) * step
        found = spread(stamps)
        assert np.all(np.diff(found) > 0.0)
        # A stamp is early by up to one step; the last row of a stamp, which is moved farthest, may
        # be late by as much.
        assert np.abs(found - true).max() < 1.5 * step


def test_times_without_order_are_kept() -> None:
    for kept in (np.zeros(5), np.array([0.0, 1.0, 1.0, 0.5]), np.arange(4.0)):
        np.testing.assert_array_equal(spread(kept), kept)


def _log(*, whole_seconds: bool) -> MeasurementSet:
    """Make a log of 0.7 turns, 10 rows per second: a line of order 60, 20″, in correlated noise."""
    random = np.random.default_rng(5)
    rows = 1440
    target = np.linspace(20.0, 272.0, rows)
    noise = np.zeros(rows)
    for row in range(1, rows):
        noise[row] = 0.8 * noise[row - 1] + random.normal(0.0, 3.0)
    angle = np.radians(target)
    time_s = 0.1 * np.arange(rows)
    reference = Reference(
        target,
        30.0 * np.cos(angle) + 20.0 * np.cos(60.0 * angle + 1.0) + noise,
        time_s=np.floor(time_s) if whole_seconds else time_s,
    )
    return MeasurementSet(Table(), None, reference, title="log")


def test_a_log_in_whole_seconds_has_the_verdict_of_the_log_with_finer_times() -> None:
    """The line is an order of the angle, which the clock does not change."""
    finer, coarse = (diagnosis_of(_log(whole_seconds=item)) for item in (False, True))
    assert finer.named is not None
    assert coarse.named is not None
    assert finer.named.name == coarse.named.name == "periodic_error"
