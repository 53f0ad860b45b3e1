"""Tests that table_rotation in VHDL equals its model for all values of the angle's used bits."""

from tb.support.simulation import simulate


def test_table_rotation() -> None:
    simulate("table_rotation", "tb.harmonic.table_rotation_bench")
