"""Runs the bench of the glitch filter in GHDL."""

from tb.support.simulation import simulate


def test_glitch_filter() -> None:
    simulate("glitch_filter", "tb.decoder.glitch_filter_bench")
