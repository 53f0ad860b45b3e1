"""Tests that the VHDL gives the difference of two angles in the shorter direction."""

from tb.support.simulation import simulate


def test_turn_difference() -> None:
    simulate("turn_difference", "tb.mean.turn_difference_bench")
