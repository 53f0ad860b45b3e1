"""Test of the witness of the index in GHDL."""

from tb.support.simulation import simulate


def test_zero_witness() -> None:
    simulate("zero_witness", "tb.decoder.zero_witness_bench")
