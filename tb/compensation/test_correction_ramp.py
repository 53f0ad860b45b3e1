"""Tests that the ramp in VHDL equals its model, bit by bit, in every scenario."""

from __future__ import annotations

from tb.support.simulation import simulate


def test_correction_ramp() -> None:
    simulate("correction_ramp", "tb.compensation.correction_ramp_bench")
