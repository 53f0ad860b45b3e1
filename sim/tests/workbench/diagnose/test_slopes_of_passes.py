"""Tests that passes over an arc that differ by straight lines of the angle are described, with the
condition that differs between them. The sets are computed in this module, with plain numpy."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.slopes_of_passes import RANDOM_WALK, SLOPES_P, slopes_of_passes
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.growth import settle
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]
EFFECTS = built_in()
ARC_DEG, PLACES, NOISE_ARCSEC = 100.0, 240, 0.8


def _diagnosed(slopes: list[float], celsius: list[float], seed: int, slow: float) -> Diagnosis:
    """Return the diagnosis of passes upwards, each with its slope in arcseconds over the arc and
    its temperature. ``slow``: standard deviation of a step of a random walk."""
    random = np.random.default_rng(seed)
    run = np.repeat(np.arange(len(slopes)), PLACES)
    angle = np.tile(np.linspace(-50.0, 50.0, PLACES), len(slopes))
    error = np.array(slopes)[run] * angle / ARC_DEG + 9.0 * np.cos(np.radians(angle + 20.0))
    error += random.normal(0.0, NOISE_ARCSEC, run.size)
    error += np.cumsum(random.normal(0.0, slow, run.size))
    time_s = 0.25 * np.arange(run.size) + 20.0 * run
    warm = np.array(celsius)[run] + random.normal(0.0, 0.02, run.size)
    reference = Reference(angle, error, run=run, time_s=time_s, temperature_c=warm)
    observations = observations_of(MeasurementSet(Table(), None, reference, title="arc"))
    return diagnose(observations, settle(default_model(), observations, EFFECTS), EFFECTS)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_two_passes_at_two_temperatures(seed: int) -> None:
    """The second pass at 27 °C has 24″ more over the arc than the first at 20 °C; u of a slope over
    the arc is σ·√(12/n); u of the difference of two slopes is √2 times as large, 0.25″."""
    found = _diagnosed([0.0, 24.0], [20.0, 27.0], seed, 0.0)
    slopes = found.slopes
    assert slopes is not None
    u_arcsec = NOISE_ARCSEC * np.sqrt(2.0 * 12.0 / PLACES)
    assert slopes.size_arcsec == pytest.approx(24.0, abs=5.0 * u_arcsec)
    # The u from the blocks has 8 degrees of freedom: χ² of 8 lies within 0.86 … 26 with p = 0.998.
    assert 0.3 * u_arcsec < slopes.sigma_arcsec < 1.9 * u_arcsec
    said = " ".join(sentences(found))
    assert "differ by a straight line of the angle: " in said
    assert "Between them temperature (20 and 27) differs, and so does the time." in said
    assert "slow change of unknown form" not in said
    assert "neither an effect nor a product" not in said
    assert found.probability["none"] <= 0.5 + 1e-9
    assert found.next_measurement is not None
    assert "once more with temperature as in the first pass" in found.next_measurement


def test_several_passes_follow_their_temperature() -> None:
    found = _diagnosed([0.0, 24.0, 8.0, 16.0, 2.0], [20.0, 26.0, 22.0, 24.0, 20.5], 4, 0.0)
    assert found.slopes is not None
    assert found.slopes.size_arcsec == pytest.approx(24.0, abs=1.3)
    assert found.slopes.sentence().endswith("The slopes follow temperature.")


@pytest.mark.parametrize("slow", [0.0, 0.3])
def test_passes_that_differ_by_noise_have_no_slope(slow: float) -> None:
    found = _diagnosed([0.0, 0.0, 0.0], [20.0, 26.0, 23.0], 5, slow)
    assert found.slopes is None


@pytest.mark.parametrize("walk", [False, True])
def test_false_alarms_in_the_fastest_and_the_slowest_noise(walk: bool) -> None:
    """In 4,000 sets of three passes, white noise and a random walk give p < 1e-4 at most twice
    1e-4: 0.8 sets expected, at most 5 with p = 0.999 (Poisson)."""
    random = np.random.default_rng(6)
    run = np.repeat(np.arange(3), 60)
    target = np.tile(np.linspace(0.0, 1.0, 60), 3)
    alarms = 0
    for _ in range(4000):
        left = random.normal(size=(3, 60))
        left = np.cumsum(left, axis=1) if walk else left
        rows = SimpleNamespace(
            target_rad=target, run=run, direction=None, time_s=None, temperature_c=None,
            speed_rad_s=None, reference_temperature_c=20.0, conditions={},
        )  # fmt: skip
        term = SimpleNamespace(effect=SimpleNamespace(settings={"arc_deg": [0.0, 57.0]}))
        solution: Any = SimpleNamespace(
            observations=SimpleNamespace(reference=rows, capture=None),
            reference_residual_arcsec=lambda left=left: left.ravel(),
            terms=[term],
            unknown_noise=(),
        )
        alarms += slopes_of_passes(solution) is not None
    assert SLOPES_P == 1e-4
    assert alarms <= 5


def test_the_factor_is_that_of_a_random_walk() -> None:
    """The covariance of a random walk is min(s, t); the means over six equal parts of it give the
    variance of the slope and of the scatter about the line."""
    fine = (np.arange(600) + 0.5) / 100.0
    part = np.kron(np.eye(6), np.full((1, 100), 0.01))
    covariance = part @ np.minimum.outer(fine, fine) @ part.T
    line = (np.arange(6) - 2.5) / np.linalg.norm(np.arange(6) - 2.5)
    about = np.eye(6) - np.outer(line, line) - np.full((6, 6), 1.0 / 6.0)
    expected = line @ covariance @ line / (np.trace(about @ covariance) / 4.0)
    assert pytest.approx(expected, abs=0.005) == RANDOM_WALK
