"""The difference of two angles in VHDL is that of the shorter way round."""

from tb.support.simulation import simulate


def test_turn_difference() -> None:
    simulate("turn_difference", "tb.mean.turn_difference_bench")
