"""Tests the quantities from which the diagnosis computes its stated probability (Grounds)."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.studies.benchmark.diagnosis import diagnosed


def test_grounds_of_stations_state_visits_and_what_was_tested() -> None:
    """The set has 24 stations, 5 cycles up and down, and a reversal error of 20 σ of the noise."""
    random = np.random.default_rng(3)
    up = np.arange(24) * 15.0
    target = np.tile(np.concatenate([up, up[::-1]]), 5)
    side = np.tile(np.repeat([1.0, -1.0], 24), 5)
    error = 80.0 * np.cos(np.radians(target)) + 1.0 * side + random.normal(0.0, 0.1, target.size)
    rows = Reference(
        target,
        error,
        run=np.zeros(target.size, dtype=np.int64),
        time_s=np.arange(target.size) * 5.0,
        cycle=np.repeat(np.arange(5), 48),
        direction=side.astype(np.int64),
    )
    _, found = diagnosed(MeasurementSet(Table(), None, rows, title="stations"))
    assert found.named is not None
    assert found.named.name == "hysteresis"
    grounds = found.grounds
    assert grounds is not None
    assert (grounds.distance.runs, grounds.distance.visits) == (0, 10.0)
    tested, untestable = len(found.candidates), len(found.untestable)
    assert grounds.distance.untested == pytest.approx(untestable / (tested + untestable), abs=0.1)
    # With the named effect in the model, only the noise of the repeats remains.
    assert grounds.distance.left == pytest.approx(1.0, abs=0.15)
    assert grounds.ways == len(found.unlike)
    assert grounds.class_size == len(found.effect_class)
    # With white noise, twice the log likelihood would rise by n·log(1 + 1²/0.1²); slow noise
    # reduces this.
    assert 100.0 < grounds.delta_bic < 240 * np.log(101.0)
    assert grounds.log_p < -50.0
    assert grounds.evidence > 0.99
