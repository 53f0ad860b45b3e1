"""Tests that a stored thermal effect keeps its own reference temperature T₀ when it is compared
with another set."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.workbench.small_sets import CAPTURE_NOISE, measurement_set, paper_error

from arctrue.measurement import MeasurementSet
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.model.growth import as_stored, fitted
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.model.model_file import read_model, write_model
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]

WARMER_K = 6.0
RATE_ARCSEC_PER_K = 2.0


def warming(disc: Float, temperature: Float, speed: float) -> Float:
    return paper_error(disc, temperature, speed) + RATE_ARCSEC_PER_K * (temperature - 20.0) * (
        np.cos(disc)
    )


def warmer_set() -> MeasurementSet:
    """Return a set of the same table that was measured on a warmer day."""
    fresh = measurement_set(lambda disc, t, speed: warming(disc, t + WARMER_K, speed), seed=2)
    capture, reference = fresh.capture, fresh.reference
    assert capture is not None
    assert reference is not None
    assert capture.temperature_c is not None
    assert reference.temperature_c is not None
    return dataclasses.replace(
        fresh,
        capture=dataclasses.replace(capture, temperature_c=capture.temperature_c + WARMER_K),
        reference=dataclasses.replace(reference, temperature_c=reference.temperature_c + WARMER_K),
    )


@pytest.mark.large
def test_a_stored_model_holds_on_a_warmer_day(tmp_path: Path) -> None:
    effects = catalogue()
    model = Model([ModelEffect("graduation_harmonics"), ModelEffect("thermal_eccentricity")])
    grown, _ = fitted(model, observations_of(measurement_set(warming)), effects)
    write_model(tmp_path / "model.toml", grown)
    stored = read_model(tmp_path / "model.toml")
    assert stored.reference_temperature_c == grown.reference_temperature_c

    def left(reference_temperature_c: float | None) -> float:
        fresh = observations_of(warmer_set(), reference_temperature_c=reference_temperature_c)
        residual = Residuals(as_stored(stored, fresh, effects)).capture_arcsec
        assert residual is not None
        return float(np.std(residual))

    # The noise of both heads and the rounding of both heads to counts have this RMS; the test adds
    # 5 % for the finite sample.
    noise = np.hypot(np.sqrt(2.0) * CAPTURE_NOISE, 0.0772 / np.sqrt(6.0))
    assert left(stored.reference_temperature_c) < 1.05 * noise
    # With the T₀ of this set, the prediction would be wrong by 6 K times 2″/K, which R₂ − R₁ shows
    # multiplied by |e^{jα} − 1| = 0.568.
    assert left(None) > 0.5 * WARMER_K * RATE_ARCSEC_PER_K * 0.568 / np.sqrt(2.0)


def test_a_set_without_temperatures_keeps_it() -> None:
    measurement = measurement_set()
    assert measurement.capture is not None
    assert measurement.reference is not None
    bare = dataclasses.replace(
        measurement,
        capture=dataclasses.replace(measurement.capture, temperature_c=None),
        reference=dataclasses.replace(measurement.reference, temperature_c=None),
    )
    model = Model([ModelEffect("graduation_harmonics")], reference_temperature_c=21.5)
    grown, _ = fitted(model, observations_of(bare), catalogue())
    assert grown.reference_temperature_c == 21.5
