"""Tests that the noise of a thermometer does not hide an effect of the temperature."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.workbench.effects.catalogue.thermal_head_drift import ThermalHeadDrift
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.likelihood_ratio import Null, evidence
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations.build import observations_of
from arctrue.workbench.observations.thermometer import without_sensor_noise
from tests.workbench.small_sets import COUNTS_PER_REV, measurement_set

Float = NDArray[np.float64]

ROWS = 3000
NOISE_K = 0.008


def _one_run(temperature_c: Float, step_s: float = 0.01) -> Float:
    rows = temperature_c.size
    return without_sensor_noise(
        temperature_c, step_s * np.arange(rows), np.zeros(rows, dtype=np.int64)
    )


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_noise_of_a_constant_temperature_is_its_mean(seed: int) -> None:
    """The result varies by less than a tenth of the noise: a mean of 3,000 rows alone would leave
    none, one wave that chance selects 1/√1500 of it."""
    shown = 21.0 + NOISE_K * np.random.default_rng((31, seed)).normal(size=ROWS)
    found = _one_run(shown)
    assert np.ptp(found) < 0.2 * NOISE_K
    assert found.mean() == pytest.approx(shown.mean(), abs=1e-9)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_slow_change_remains(seed: int) -> None:
    """A rise with a swing remains within a quarter of the noise (RMS): with 40 waves, √(40/3000)
    of the noise is left, 0.12."""
    along = np.linspace(0.0, 1.0, ROWS)
    true = 20.0 + 1.3 * along + 0.2 * np.sin(12.0 * along)
    shown = true + NOISE_K * np.random.default_rng((32, seed)).normal(size=ROWS)
    assert np.sqrt(np.mean((_one_run(shown) - true) ** 2)) < 0.25 * NOISE_K


def test_other_changes_are_kept() -> None:
    """A spike, a jump between two rows without noise, rows far apart in time and a run of few rows
    keep their values."""
    random = np.random.default_rng(33)
    shown = 20.0 + NOISE_K * random.normal(size=ROWS)
    spike = shown.copy()
    spike[700] += 3.0
    assert np.array_equal(_one_run(spike), spike)
    jump = np.where(np.arange(ROWS) < 1100, 20.0, 20.5)
    assert _one_run(jump) == pytest.approx(jump, abs=0.02)
    assert np.array_equal(_one_run(shown, step_s=30.0), shown)
    assert np.array_equal(_one_run(shown[:40]), shown[:40])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_large_drift_of_a_head_is_seen(seed: int) -> None:
    """Head 2 moves by 9.6″ in the only warm run of four, 4 K above the others, and the sensor
    scatters by 5 mK. The fitted size is the true one within five standard uncertainties of the
    index (±1 count of each head in four runs: 0.03″/K each), and the gain exceeds 40, which chance
    exceeds with p = 2·10⁻¹⁰."""
    measured = measurement_set(seed=seed, reference=False)
    capture = measured.capture
    assert capture is not None
    count_arcsec = 1_296_000.0 / COUNTS_PER_REV
    warm = capture.run == 3
    moved = np.round(capture.head2_counts + np.where(warm, 9.6 / count_arcsec, 0.0))
    noise_k = 0.005 * np.random.default_rng((34, seed)).normal(size=warm.size)
    shown = np.where(warm, 24.0, 20.0) + noise_k
    there = replace(capture, head2_counts=moved.astype(np.int64), temperature_c=shown)
    observations = observations_of(replace(measured, capture=there))
    base = [Term(built_in()["graduation_harmonics"](), {})]
    found = evidence(Null(Residuals(fit(base, observations))), ThermalHeadDrift(), {})
    grown = found.base.solution_with(ThermalHeadDrift(), {}, found.score)
    assert grown.coefficients[-1] == pytest.approx(2.4, abs=0.15)
    assert found.gain > 40.0
