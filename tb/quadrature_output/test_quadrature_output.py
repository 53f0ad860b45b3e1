"""Runs in GHDL the benches of the quadrature output, alone and connected to the decoder."""

from tb.support.simulation import simulate


def test_quadrature_output() -> None:
    simulate("quadrature_output", "tb.quadrature_output.quadrature_output_bench")


def test_loop_back_into_the_decoder() -> None:
    simulate(
        "quadrature_loopback_harness",
        "tb.quadrature_output.quadrature_loopback_bench",
    )
