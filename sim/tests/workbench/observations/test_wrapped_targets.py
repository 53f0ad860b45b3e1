"""Tests that the workbench unwraps the angle of a log whose recorder writes the angle modulo one
turn."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.studies.benchmark.diagnosis import diagnosed
from arctrue.workbench.observations.wrapped_targets import unwrapped


def _log(target: np.ndarray, *, step_s: float = 0.1, run: np.ndarray | None = None) -> Reference:
    time_s = np.arange(target.size) * step_s
    return Reference(target, np.zeros(target.size), time_s=time_s, run=run)


@pytest.mark.parametrize("deg_s", [9.7, -9.7])
def test_angles_continue_past_the_turn(deg_s: float) -> None:
    target = 40.0 + deg_s * 0.1 * np.arange(1500)
    run = np.repeat([0, 1, 2], 500)
    found = unwrapped(_log(np.mod(target, 360.0), run=run)).target_deg
    np.testing.assert_allclose(found - found[0], target - target[0], atol=1e-9)


@pytest.mark.parametrize(
    "target",
    [
        # The targets are either already unwrapped, or within one turn, or an arc up and down, or
        # the stations of a polygon.
        40.0 + 0.97 * np.arange(1500),
        0.5 * np.arange(720),
        np.concatenate([np.arange(100.0), np.arange(99.0, -1.0, -1.0)]),
        np.tile(15.0 * np.arange(24), 10),
    ],
)
def test_other_angles_are_kept(target: np.ndarray) -> None:
    assert np.array_equal(unwrapped(_log(target)).target_deg, target)


def test_a_table_that_had_time_to_go_back_is_not_unwrapped() -> None:
    target = np.tile(np.arange(0.0, 360.0, 0.5), 3)
    log = _log(target)
    assert log.time_s is not None
    log.time_s[720:] += 20.0
    log.time_s[1440:] += 20.0
    assert np.array_equal(unwrapped(log).target_deg, target)


def test_an_order_that_is_not_whole_is_found_in_a_wrapped_log() -> None:
    random = np.random.default_rng(1)
    time_s = 0.1 * np.arange(1500)
    target = 40.0 + 8.3 * time_s
    angle = np.radians(target)
    error = 20.0 * np.cos(angle) + 3.0 * np.cos(31.37 * angle) + random.normal(size=angle.size)
    log = Reference(np.mod(target, 360.0), error, time_s=time_s)
    _, found = diagnosed(MeasurementSet(Table(), None, log, title="wrapped"))
    assert found.named is not None
    assert found.named.name == "periodic_error"
    parameters = found.named.parameters()
    assert parameters["order"].value == pytest.approx(31.37, abs=4.0 * parameters["order"].sigma)
