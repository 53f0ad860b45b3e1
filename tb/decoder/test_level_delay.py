"""Tests that the VHDL delays a head's levels by any number of clocks up to 255."""

from tb.support.simulation import simulate


def test_level_delay() -> None:
    simulate("level_delay", "tb.decoder.level_delay_bench")
