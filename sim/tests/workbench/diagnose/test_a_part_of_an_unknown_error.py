"""Tests that a known effect which is a part of an unknown error is stated with its size."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data

STATIONS, CYCLES = 24, 5
REVERSAL_ARCSEC = 1.2
"""Difference of the readings in both directions."""
PER_KELVIN_ARCSEC, NOISE_ARCSEC = 0.75, 0.15


def _both(seed: int) -> MeasurementSet:
    """Return stations up and down; the reading changes by ±0.6″ with the direction and by 0.75″/K
    with a temperature that swings three times in the record."""
    random = np.random.default_rng([7, seed])
    up = np.arange(STATIONS) * 360.0 / STATIONS
    angle = np.tile(np.concatenate([up, up[::-1]]), CYCLES)
    direction = np.tile(np.repeat([1, -1], STATIONS), CYCLES)
    time_s = 25.0 * np.arange(angle.size)
    warm = 21.0 + 1.1 * np.sin(2.0 * np.pi * time_s / 1_950.0 + 0.7)
    error = 8.0 * np.cos(np.radians(angle) - 0.4) + 1.2 * np.cos(2.0 * np.radians(angle))
    error += 0.5 * REVERSAL_ARCSEC * direction + PER_KELVIN_ARCSEC * (warm - 21.0)
    reference = Reference(
        angle,
        error + random.normal(0.0, NOISE_ARCSEC, angle.size),
        time_s=time_s,
        cycle=np.repeat(np.arange(CYCLES), 2 * STATIONS),
        direction=direction,
        temperature_c=warm,
    )
    return MeasurementSet(Table(), None, reference, title="reversal and temperature")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_reversal_error_has_its_size_although_another_error_is_unknown(seed: int) -> None:
    """The difference of the means of 120 readings has u = 0.15″·√(2/120) = 0.0194″."""
    found = diagnosis_of(_both(seed))
    said = " ".join(sentences(found))
    assert found.verdict == "unknown"
    assert "None of the known effects fits" not in said
    assert "hysteresis explains a part of it" in said
    size = float(said.split("reversal error ")[1].split("″")[0])
    # 0.1″ is 5 standard uncertainties.
    assert size == pytest.approx(REVERSAL_ARCSEC, abs=0.1)
    assert "remains: (T − T₀), reference only, 0.7" in said
    data = diagnosis_data(found, [])
    (first,) = (item for item in data["candidates"] if item["effect"] == "hysteresis")
    assert first["parameters"]["reversal_error"]["sigma"] == pytest.approx(0.0194, rel=0.3)
