"""Runs the bench of index_zero in GHDL."""

from tb.support.simulation import simulate


def test_index_zero() -> None:
    simulate("index_zero", "tb.decoder.index_zero_bench")
