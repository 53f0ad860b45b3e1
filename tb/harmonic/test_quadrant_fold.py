"""Tests that quadrant_fold in VHDL equals its model."""

from tb.support.simulation import simulate


def test_quadrant_fold() -> None:
    simulate("quadrant_fold", "tb.harmonic.quadrant_fold_bench")
