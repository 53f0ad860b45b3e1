"""Tests that the phase of one lane in VHDL equals its model and takes 5 clocks."""

from tb.support.simulation import simulate


def test_phase_lane() -> None:
    simulate("phase_lane", "tb.phase.phase_lane_bench")
