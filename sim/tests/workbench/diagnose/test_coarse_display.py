"""Tests of logs whose display rounds to a step that is larger than the noise.

The logs are computed in this module, with plain numpy.
"""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.growth import settle
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
STEP_ARCSEC = 20.0
PERIOD_S = 479.0
ROWS = 500


def _diagnosed(amplitude_arcsec: float, drift_arcsec: float) -> Diagnosis:
    """Diagnose a log over 10° with one line and a drift; the noise of a reading is 0.4″."""
    random = np.random.default_rng(1)
    time_s = 5.0 * np.arange(ROWS)
    error = amplitude_arcsec * np.sin(2.0 * np.pi * time_s / PERIOD_S + 0.3)
    error += drift_arcsec * time_s / time_s[-1] + 0.4 * random.normal(size=ROWS)
    reference = Reference(
        target_deg=np.linspace(0.0, 10.0, ROWS),
        error_arcsec=STEP_ARCSEC * np.round(error / STEP_ARCSEC),
        run=np.zeros(ROWS, dtype=np.int64),
        time_s=time_s,
        direction=np.ones(ROWS, dtype=np.int64),
    )
    observations = observations_of(MeasurementSet(Table(), None, reference, title="coarse"))
    return diagnose(observations, settle(default_model(), observations, EFFECTS), EFFECTS)


@pytest.mark.large
def test_a_line_that_no_rounding_can_cause_is_named() -> None:
    """The rounding error stays within half a step, so that none of its lines exceeds 2/π = 0.64
    steps (the fundamental of a square wave); this line has 1.1 steps."""
    found = _diagnosed(1.1 * STEP_ARCSEC, 0.0)
    assert found.named is not None
    assert found.named.name == "periodic_error"
    period = found.named.parameters()["period_time"].value
    assert abs(period - PERIOD_S) < 0.02 * PERIOD_S


def test_a_line_that_the_rounding_can_cause_is_not_named() -> None:
    """With a drift through 2.4 steps, the rounding of the display may cause a line of 0.45 steps:
    the diagnosis names no line and states the rounding."""
    found = _diagnosed(0.45 * STEP_ARCSEC, 2.4 * STEP_ARCSEC)
    assert found.named is None
    assert found.verdict == "cannot_tell"
    assert "rounded to 20″" in sentences(found)[0]


def test_the_rounding_of_one_turn_is_no_resonance() -> None:
    """A display rounds to 0.5″, sixteen times the noise. The rounding error of at most 0.25″
    follows the error of the disc and is neither a resonance nor noise that is not white."""
    random = np.random.default_rng(4)
    angle = np.linspace(0.0, 360.0, 1900, endpoint=False)
    error = 22.0 * np.cos(np.radians(angle) + 0.7) + 1.1 * np.cos(2.0 * np.radians(angle) - 1.0)
    error += 0.03 * random.normal(size=angle.size)
    reference = Reference(
        target_deg=angle, error_arcsec=0.5 * np.round(error / 0.5), time_s=2.0 * angle
    )
    observations = observations_of(MeasurementSet(Table(), None, reference, title="one turn"))
    found = diagnose(observations, settle(default_model(), observations, EFFECTS), EFFECTS)
    assert found.verdict in ("adequate", "cannot_tell")
