"""Tests that the ramp in VHDL equals its model, bit by bit, in every scenario."""

from __future__ import annotations

import pytest
from sim.tests.gateware.correction_ramp_scenarios import SCENARIOS

from tb.support.simulation import simulate

LONG_CLOCKS = 13_000
LONG = [scenario.correction.size > LONG_CLOCKS for scenario in SCENARIOS]


@pytest.mark.parametrize(
    "are_long", [False, pytest.param(True, marks=pytest.mark.large)], ids=["short", "long"]
)
def test_correction_ramp(are_long: bool) -> None:
    """The long scenarios have smooth steps that last many ticks of 256 clocks; most have a marker
    in every tick."""
    chosen = [place for place, is_long in enumerate(LONG) if is_long is are_long]
    simulate(
        "correction_ramp",
        "tb.compensation.correction_ramp_bench",
        testcase=[f"equals_the_model/scenario={place}" for place in chosen],
    )
