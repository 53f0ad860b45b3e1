"""Runs in GHDL the benches of the quadrature output, alone and connected to the decoder."""

import pytest

from tb.quadrature_output.quadrature_loopback_bench import CASES
from tb.support.simulation import simulate


def test_quadrature_output() -> None:
    simulate("quadrature_output", "tb.quadrature_output.quadrature_output_bench")


SHORTEST = ("edge_every_clock_odd_turn", "smallest_turn", "spacing_3")
"""Cases that run without ``large``; the others have longer filters, other spacings and a position
that wraps."""


@pytest.mark.parametrize(
    "are_large", [False, pytest.param(True, marks=pytest.mark.large)], ids=["shortest", "others"]
)
def test_loop_back_into_the_decoder(are_large: bool) -> None:
    chosen = [place for place, name in enumerate(CASES) if (name not in SHORTEST) is are_large]
    simulate(
        "quadrature_loopback_harness",
        "tb.quadrature_output.quadrature_loopback_bench",
        testcase=[f"loses_no_count/name={place}" for place in chosen],
    )
