"""Tests of logs whose clock has coarse steps."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.observations.coarse_times import spread


def test_spread_times_differ_from_the_true_ones_by_at_most_a_step_and_a_half() -> None:
    random = np.random.default_rng(3)
    true = np.cumsum(random.uniform(0.2, 0.4, 500))
    for step in (0.01, 1.0, 2.5):
        stamps = np.floor(true / step) * step
        found = spread(stamps)
        assert np.all(np.diff(found) > 0.0)
        # A stamp is early by less than one step of the clock. The bound adds half a step, because
        # the rows of one stamp get even times, although their true times are not even.
        assert np.abs(found - true).max() < 1.5 * step


def test_times_without_order_are_kept() -> None:
    for kept in (np.zeros(5), np.array([0.0, 1.0, 1.0, 0.5]), np.arange(4.0)):
        np.testing.assert_array_equal(spread(kept), kept)


def _log(*, whole_seconds: bool) -> MeasurementSet:
    """Make a log of 0.7 turns with 10 rows per second. The error is a sine of order 1 (30″), a sine
    of order 60 (20″), and correlated noise."""
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


@pytest.mark.large
def test_a_log_in_whole_seconds_has_the_verdict_of_the_log_with_finer_times() -> None:
    """The coarse clock does not change the sine of order 60, which depends only on the angle."""
    finer, coarse = (diagnosis_of(_log(whole_seconds=item)) for item in (False, True))
    assert finer.named is not None
    assert coarse.named is not None
    assert finer.named.name == coarse.named.name == "periodic_error"
