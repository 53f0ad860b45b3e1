"""Tests that the list of regular errors contains lines that are too fast for the averaged rows of
the search. In an earlier version the list for a long log lacked some of the largest lines."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.detections import Detections
from arctrue.workbench.diagnose.regular import detections_of
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.observations.build import observations_of
from tests.workbench.noisy_logs import driven_oscillator, ornstein_uhlenbeck

ROWS, STEP_S, TURN_S = 9000, 0.4, 3600.0
LINES = {9.1: 2.0, 33.0: 1.5, 2.7: 1.0}
"""Periods in seconds and amplitudes. The search averages 6 rows, 2.4 s; it covers periods above
9.6 s."""


def _detections(random: np.random.Generator, error_arcsec: np.ndarray) -> Detections:
    time_s = STEP_S * np.arange(ROWS)
    angle = 2.0 * np.pi * time_s / TURN_S
    slow = 2.0 * ornstein_uhlenbeck(random, time_s, 60.0) + 0.5 * random.normal(size=ROWS)
    reference = Reference(
        target_deg=np.degrees(angle),
        error_arcsec=error_arcsec + 50.0 * np.cos(angle + 1.0) + slow,
        time_s=time_s,
        run=np.zeros(ROWS, dtype=np.int64),
    )
    effects = built_in()
    base = [Term(effects["graduation_harmonics"](), {})]
    observed = observations_of(MeasurementSet(Table(), None, reference))
    return detections_of(fit(base, observed), effects)


@pytest.mark.parametrize("seed", range(2))
def test_each_line_is_listed_with_its_size(seed: int) -> None:
    """With white noise of 0.5″ and the slow noise, an amplitude at 9.1 s has 2u = 0.1″."""
    random = np.random.default_rng(seed)
    time_s = STEP_S * np.arange(ROWS)
    error = sum(
        size * np.cos(2.0 * np.pi * time_s / period + random.uniform(0.0, 6.0))
        for period, size in LINES.items()
    )
    found = _detections(random, np.asarray(error))
    listed = {}
    for cause in found.causes:
        listed |= {round(cause.period_s(line), 1): line.amplitude_arcsec for line in cause.lines}
    listed |= {round(line.period_s, 1): line.amplitude_arcsec for line in found.fast}
    assert sorted(listed) == sorted(LINES)
    for period_s, size in LINES.items():
        assert listed[period_s] == pytest.approx(size, abs=0.2)
    assert "Single rows show lines too fast" in " ".join(found.sentences())


def test_an_oscillation_that_noise_drives_is_no_line() -> None:
    """A resonance of 2.7 s that keeps its phase for 60 s of an hour has no phase of its own."""
    random = np.random.default_rng(5)
    time_s = STEP_S * np.arange(ROWS)
    shaken = driven_oscillator(random, time_s, 2.7, np.pi * 60.0 / 2.7)
    assert _detections(random, shaken).fast == ()
