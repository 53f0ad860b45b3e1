"""Tests that a line has one name and one size: it is not an oscillation of the noise too, and an
order is not a line in time at each of its speeds."""

from __future__ import annotations

import numpy as np

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.regular import detections_of
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.noisy_logs import ornstein_uhlenbeck

SIDEREAL_S = 86_164.1
STEP_S, FAST_S = 5.0, 3.7
"""At a step of 5 s, a line of 3.7 s looks like 1/(1/3.7 − 1/5) = 14.23 s, or like 7.71 s."""


def _set(time_s: np.ndarray, target_deg: np.ndarray, error: np.ndarray) -> MeasurementSet:
    run = np.zeros(time_s.size, dtype=np.int64)
    reference = Reference(target_deg=target_deg, error_arcsec=error, time_s=time_s, run=run)
    return MeasurementSet(Table(), None, reference)


def test_a_line_faster_than_the_rows() -> None:
    random = np.random.default_rng(1)
    time_s = STEP_S * np.arange(800)
    error = 2.0 * np.cos(2.0 * np.pi * time_s / FAST_S + 1.0)
    error += 0.8 * ornstein_uhlenbeck(random, time_s, 15.0) + 0.4 * random.normal(size=800)
    found = diagnosis_of(_set(time_s, time_s * 360.0 / SIDEREAL_S, error))
    said = " ".join(sentences(found))
    assert found.verdict == "named"
    assert "or 14.231 s" in said
    assert "noise-driven" not in said
    assert "or 3.7 s would look the same" in said


def test_an_order_at_two_speeds_is_no_line_in_time() -> None:
    """Order 2.37 at 20°/s and 10°/s has the periods 7.6 s and 15.2 s, which are no lines."""
    random = np.random.default_rng(2)
    step_s = 0.1
    angle = np.concatenate(
        [20.0 * step_s * np.arange(1440), 2880.0 - step_s * 10 * np.arange(1440)]
    )
    run = np.repeat([0, 1], 1440)
    time_s = step_s * np.arange(2880) + 5.0 * run
    error = 2.0 * np.cos(2.37 * np.radians(angle)) + 0.4 * random.normal(size=2880)
    reference = Reference(
        target_deg=angle,
        error_arcsec=error,
        time_s=time_s,
        run=run,
        direction=np.where(run == 0, 1.0, -1.0),
    )
    effects = built_in()
    base = [Term(effects["graduation_harmonics"](), {})]
    observed = observations_of(MeasurementSet(Table(), None, reference))
    found = detections_of(fit(base, observed), effects)
    orders = [line.rate for cause in found.causes for line in cause.lines if not cause.in_time]
    assert len(found.causes) == len(orders) == 1
    assert abs(orders[0] - 2.37) < 0.02


def test_a_drift_under_a_line() -> None:
    """A drift of 15″ in 5,000 s, under a line of 9″, is known to 0.3″ in noise of 1″ that keeps its
    value for 8 s. On an arc of 20° the model has no orders."""
    random = np.random.default_rng(3)
    time_s = np.cumsum(random.uniform(2.5, 4.0, 1500))
    error = 9.0 * np.cos(2.0 * np.pi * time_s / 480.0) + 0.003 * time_s
    error += ornstein_uhlenbeck(random, time_s, 8.0)
    measured = _set(time_s, time_s * 360.0 / SIDEREAL_S, error)
    found = detections_of(fit([], observations_of(measured)), built_in())
    assert found.drift is not None
    true = 0.003 * float(np.ptp(time_s))
    assert abs(found.drift.size_arcsec - true) < 3.0 * found.drift.sigma_arcsec < 1.5
    assert "changes evenly by" in " ".join(found.sentences())
