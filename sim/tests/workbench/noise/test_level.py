"""Tests that noise whose level changes with time is recognised, and gives neither a jump nor an
unknown error. The noise is drawn in this module.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.diagnose.regular import detections_of
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.model.growth import settle
from arctrue.workbench.model.model import default_model
from arctrue.workbench.noise.level import noise_level
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
ROWS, STEP_S = 1400, 2.0


def _relaxing(random: np.random.Generator, rows: int, length: float) -> NDArray[np.float64]:
    """Return noise of RMS 1 whose correlation falls to 1/e within ``length`` rows."""
    kept = np.exp(-1.0 / length)
    found = np.empty(rows)
    found[0] = random.standard_normal()
    for row in range(1, rows):
        found[row] = kept * found[row - 1] + np.sqrt(1.0 - kept**2) * random.standard_normal()
    return found


def _gusts(seed: int) -> NDArray[np.float64]:
    """Return white noise of 0.3″ and slow noise of 0.4″, which is six times as large in gusts."""
    random = np.random.default_rng(seed)
    rows = np.arange(ROWS)
    gust = (rows % 350) > 300
    slow = 0.4 * _relaxing(random, ROWS, 8.0) * np.where(gust, 6.0, 1.0)
    return slow + 0.3 * random.standard_normal(ROWS)


def _log(error_arcsec: NDArray[np.float64]) -> MeasurementSet:
    return MeasurementSet(
        table=Table(),
        reference=Reference(
            target_deg=np.linspace(0.0, 12.0, error_arcsec.size),
            error_arcsec=error_arcsec,
            run=np.zeros(error_arcsec.size, dtype=np.int64),
            time_s=np.arange(error_arcsec.size, dtype=np.float64) * STEP_S,
        ),
    )


@pytest.mark.large
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_gusts_give_no_jump(seed: int) -> None:
    observations = observations_of(_log(_gusts(seed)))
    solution = fit(settle(default_model(), observations, EFFECTS), observations)
    found = detections_of(solution, EFFECTS)
    assert found.steps == ()
    assert found.causes == ()
    assert found.noise_level_ratio is not None
    assert not found.not_noise
    # The level of all noise in a gust is √(2.4² + 0.3²)/√(0.4² + 0.3²) = 4.8 times the level
    # outside. The level of the innovations changes by about half as much, because the white part
    # does not change.
    assert 2.0 < found.noise_level_ratio < 8.0


def test_the_verdict_on_gusts_names_nothing() -> None:
    observations = observations_of(_log(_gusts(4)))
    found = diagnose(observations, settle(default_model(), observations, EFFECTS), EFFECTS)
    assert found.verdict in ("adequate", "cannot_tell")
    assert any("noise level of the reference changes" in text for text in sentences(found))


@pytest.mark.large
def test_a_step_in_gusts_is_found() -> None:
    """A step of 9″ between two gusts, eighteen times the noise there."""
    error = _gusts(5) + 9.0 * (np.arange(ROWS) >= 560)
    observations = observations_of(_log(error))
    solution = fit(settle(default_model(), observations, EFFECTS), observations)
    (step,) = detections_of(solution, EFFECTS).steps
    assert step.time_s == pytest.approx(560 * STEP_S, abs=2.0 * STEP_S)
    assert abs(step.size_arcsec - 9.0) < 4.0 * step.sigma_arcsec


def test_one_level_has_no_local_level() -> None:
    """Of 300 records of white noise, at a level of 10⁻⁴, none may show a change; noise with tails
    (Student's t of three degrees of freedom) has one level too."""
    random = np.random.default_rng(8)
    assert not any(noise_level(random.standard_normal(800)) for _ in range(300))
    assert sum(noise_level(random.standard_t(3.0, 800)) is not None for _ in range(300)) <= 1


def test_the_ratio_of_levels() -> None:
    """The noise is three times as large in a fifth of the rows. The stated ratio, of a high to a
    low quantile of the local RMS, is about 3; the local RMS scatters by 13 %."""
    random = np.random.default_rng(9)
    loud = np.where(np.arange(2000) % 500 < 100, 3.0, 1.0)
    found = noise_level(loud * random.standard_normal(2000))
    assert found is not None
    assert 2.4 < found.ratio < 4.8
