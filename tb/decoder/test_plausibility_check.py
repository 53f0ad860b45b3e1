"""Runs the bench of the plausibility check in GHDL."""

from tb.support.simulation import simulate


def test_plausibility_check() -> None:
    simulate("plausibility_check", "tb.decoder.plausibility_check_bench")
