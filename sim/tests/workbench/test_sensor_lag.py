"""Tests that the time constant of the set's thermometer is fitted together with the model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from arctrue.cli import main
from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.measurement import write_measurement_set
from arctrue.studies.simulate.experiment import short
from arctrue.studies.simulate.simulated_set import SimulatedSet, Wanted, simulate_set
from arctrue.table.temperature import TemperatureCourse
from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.model import Model, ModelEffect, default_model
from arctrue.workbench.model.model_file import write_model
from arctrue.workbench.model.sensor_lag import NoLagError, fitted_sensor_lag, without_lag
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

LAG_S = 60.0
ARCSEC_K = 0.9e-6 / 0.053975 * 648_000 / np.pi
"""Amplitude in arcseconds per kelvin when the centre shifts by 0.9 µm/K, at the radius of the
disc."""


def _simulated(noise: list[Wanted]) -> SimulatedSet:
    return simulate_set([Wanted("thermal_eccentricity", 0.9)], short(), 1, noise=noise)


@pytest.fixture(scope="module")
def lagging() -> SimulatedSet:
    return _simulated([Wanted("sensor_lag", LAG_S / 60.0)])


def _model() -> Model:
    base = default_model()
    return replace(base, effects=[*base.effects, ModelEffect("thermal_eccentricity")])


def _lag(made: SimulatedSet) -> Parameter:
    observations = observations_of(made.measurement)
    model, _ = fitted(_model(), observations, built_in())
    return fitted_sensor_lag(model, observations, built_in())


@pytest.mark.large
def test_the_lag_is_found_within_its_uncertainty(lagging: SimulatedSet) -> None:
    lag = _lag(lagging)
    assert lag.value == pytest.approx(LAG_S, abs=2.0 * lag.sigma)
    assert lag.sigma < 0.05 * LAG_S


@pytest.mark.large
def test_a_thermometer_that_does_not_lag_is_reported_as_such() -> None:
    lag = _lag(_simulated([]))
    assert lag.value < 2.0 * lag.sigma < 0.1 * LAG_S


@pytest.mark.large
def test_one_temperature_tells_no_lag(lagging: SimulatedSet) -> None:
    capture = lagging.measurement.capture
    assert capture is not None
    assert capture.temperature_c is not None
    observations = observations_of(lagging.measurement)
    with pytest.raises(NoLagError, match="does not determine the lag"):
        fitted_sensor_lag(*_fitted_default(lagging), built_in())
    assert observations.capture is not None
    bare = replace(observations, capture=replace(observations.capture, temperature_c=None))
    with pytest.raises(NoLagError, match="needs a capture with temperature_c"):
        fitted_sensor_lag(default_model(), bare, built_in())


def _fitted_default(made: SimulatedSet) -> tuple[Model, Observations]:
    """Fit the default model, which has no thermal effect, to the set."""
    observations = observations_of(made.measurement)
    model, _ = fitted(default_model(), observations, built_in())
    return model, observations


def test_the_lag_is_taken_off_against_the_exact_course() -> None:
    """The temperature without the lag equals the true temperature. The test computes the
    thermometer's T_s exactly, for a temperature that changes along straight lines with corners; the
    parabola that is fitted to T_s has no error on a straight line."""
    course = TemperatureCourse((0.0, 100.0, 400.0), (20.0, 20.0, 26.0))
    time_s = np.arange(110.0, 390.0, 0.25)
    shown = course.lagging(time_s, LAG_S)
    found = without_lag(shown, time_s, np.zeros(time_s.size, dtype=np.int64), LAG_S)
    # The bound is the third derivative of T_s, 0.02·e^(−t/τ)/τ² K/s³, times τ·h²/2 at the ends,
    # where h = τ/16.
    bound = LAG_S * 0.02 / LAG_S**2 * (LAG_S / 16.0) ** 2 / 2.0
    assert np.abs(found - course.at(time_s)).max() < bound
    assert np.abs(shown - course.at(time_s)).max() > 1.0


@pytest.mark.large
def test_export_fits_the_lag_and_the_rate_with_it(lagging: SimulatedSet, tmp_path: Path) -> None:
    """The export fits the lag and the rate together: the file contains the lag for the firmware,
    and the rate in it refers to the temperature of the table, not to that of the thermometer."""
    write_measurement_set(tmp_path / "set", lagging.measurement)
    observations = observations_of(lagging.measurement)
    model, _ = fitted(_model(), observations, built_in())
    write_model(tmp_path / "model.toml", model)
    words = ["export", str(tmp_path / "set"), "--model", str(tmp_path / "model.toml")]
    path = tmp_path / "coefficients.toml"
    words += ["--fit-sensor-lag", "--coefficients", str(path)]
    answer = CliRunner().invoke(main, words)
    assert answer.exit_code == 0, answer.output
    assert "the thermometer lags by" in answer.output
    coefficients = read_coefficient_file(path)
    assert coefficients.thermal is not None
    assert coefficients.thermal.time_constant_s == pytest.approx(LAG_S, abs=3.0)
    rate = abs(coefficients.thermal.change_counts(1, coefficients.thermal.reference_c + 1.0))
    count_arcsec = 1_296_000 / coefficients.counts_per_rev
    assert rate * count_arcsec == pytest.approx(ARCSEC_K, rel=0.02)
    wrong = CliRunner().invoke(main, [*words, "--sensor-lag", "60"])
    assert wrong.exit_code == 2
    assert "stated or fitted" in wrong.output
