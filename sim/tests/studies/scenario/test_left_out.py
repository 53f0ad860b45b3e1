"""Test that clocks of a pause that the simulation omits change no turn, except the turn with the
pause and the last turn, which the test does not compare."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sim.tests.instrument.sizes import LANES, SAMPLES

from arctrue.studies.scenario import ScenarioResult, read_scenario, run_scenario

PAUSED_TURN, TURNS = 3, 6
SHORT_S, LONG_S = 0.5, 5.0

SAME_RAD = 1e-9
"""Largest permitted difference in rad between the results of both runs. It covers the rounding
errors of float64, because the longer run reaches the same angle some seconds later."""

SCENARIO = f"""
format = 1
title = "a pause of which more or less is run"
[scale]
lines = 64
lanes = {LANES}
samples = {SAMPLES}
[table]
noise_arcsec = 0
[motion]
legs = [ {{ turns = 2.5 }}, {{ pause_s = 900, run_s = RUN_S }}, {{ turns = 3.5 }} ]
[firmware]
orders = 8
keep = 0
"""


def run(folder: Path, run_s: float) -> ScenarioResult:
    path = folder / "pause.toml"
    path.write_text(SCENARIO.replace("RUN_S", str(run_s)))
    return run_scenario(read_scenario(path))


@pytest.mark.large
def test_the_rest_of_a_pause_may_be_left_out(tmp_path: Path) -> None:
    short = run(tmp_path, SHORT_S)
    long = run(tmp_path, LONG_S)
    assert long.clocks - short.clocks > 0.9 * (LONG_S - SHORT_S) * short.scenario.clock_hz
    arcsec = np.rad2deg(SAME_RAD) * 3600
    for before, after in zip(short.turns, long.turns, strict=True):
        if before.number in (PAUSED_TURN, TURNS):
            # PAUSED_TURN contains the pause, and the run ends in the last turn.
            continue
        assert before.corrected is not None
        assert after.corrected is not None
        np.testing.assert_allclose(
            after.corrected.amplitude_arcsec, before.corrected.amplitude_arcsec, atol=arcsec
        )
        assert abs(after.corrected.lowest_arcsec - before.corrected.lowest_arcsec) < arcsec
        assert after.flags == before.flags
        assert [t["result"] for t in after.telemetry if t["result"] != "refused"] == [
            t["result"] for t in before.telemetry if t["result"] != "refused"
        ]
