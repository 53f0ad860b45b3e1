"""Tests that a multiple of declared teeth with fewer than four rows a period belongs to the drive,
and not to an oscillation or to an effect of its own."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.regular import detections_of
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.observations.build import observations_of
from tests.workbench.noisy_logs import ornstein_uhlenbeck

TEETH, ROWS = 124, 720
"""Teeth, and rows per turn: the second multiple has 2.9 rows a period."""


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.large) for n in (1, 2))])
def test_the_second_multiple(seed: int) -> None:
    """In one turn in each direction, with noise of 0.8″ with a time constant of 3 s and white noise
    of 0.3″, both amplitudes have u = 0.03″."""
    random = np.random.default_rng(seed)
    own = np.arange(ROWS) / 1.2
    angle_deg = np.concatenate([0.6 * own, 360.0 - 0.6 * own])
    time_s = np.concatenate([own, own + 620.0])
    angle = np.radians(angle_deg)
    error = 15.0 * np.cos(angle + 1.0)
    error += 3.0 * np.cos(TEETH * angle - 0.3) + np.cos(2 * TEETH * angle - 1.2)
    error += 0.8 * ornstein_uhlenbeck(random, time_s, 3.0) + 0.3 * random.normal(size=time_s.size)
    reference = Reference(
        target_deg=angle_deg, error_arcsec=error, time_s=time_s, run=np.repeat([0, 1], ROWS)
    )
    measurement = MeasurementSet(Table(drive_gear_teeth=TEETH), None, reference)
    effects = built_in()
    base = [Term(effects["graduation_harmonics"](), {})]
    found = detections_of(fit(base, observations_of(measurement)), effects)
    assert [cause.effect.name for cause in found.causes] == ["drive_gear_error"]
    sizes = {line.multiple: line.amplitude_arcsec for line in found.causes[0].lines}
    assert sizes == {1: pytest.approx(3.0, abs=0.1), 2: pytest.approx(1.0, abs=0.1)}
    assert found.oscillation is None
    assert found.steps == ()
