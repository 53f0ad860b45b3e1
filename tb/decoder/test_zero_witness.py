"""Runs the bench of zero_witness, which compares an index mark with the counts of the other head,
in GHDL."""

from tb.support.simulation import simulate


def test_zero_witness() -> None:
    simulate("zero_witness", "tb.decoder.zero_witness_bench")
