"""Tests that an order which a load changes in every other pass is not named as a line in time."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from tests.workbench.base_diagnosis import diagnosis_of

STATIONS, PASSES, DWELL_S, PAUSE_S = 24, 8, 5.0, 30.0


@pytest.mark.parametrize("seed", range(2))
def test_a_load_in_every_other_pass(seed: int) -> None:
    """The dwell times scatter by 10 %. Passes begin 150 s apart: order 2 with the load on and off
    looks like a line of 60 s, which changes its sign from pass to pass."""
    random = np.random.default_rng(seed)
    run = np.repeat(np.arange(PASSES), STATIONS)
    dwell = DWELL_S * random.uniform(0.9, 1.1, run.size)
    time_s = np.cumsum(dwell) + PAUSE_S * run
    target = np.tile(np.arange(STATIONS) * 360.0 / STATIONS, PASSES)
    wave = np.cos(2.0 * np.radians(target) + 1.0)
    reference = Reference(
        target_deg=target,
        error_arcsec=3.0 * np.cos(np.radians(target))
        + 1.0 * (run % 2) * wave
        + random.normal(0.0, 0.15, run.size),
        time_s=time_s,
        run=run,
    )
    found = diagnosis_of(MeasurementSet(Table(), None, reference))
    assert found.verdict != "named"
    assert "the speed varies" not in " ".join(sentences(found))
