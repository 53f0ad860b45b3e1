"""Runs in GHDL the benches of the quadrature output, alone and connected to the decoder."""

import pytest
from sim.tests.gateware.quadrature_output_scenarios import SCENARIOS

from tb.quadrature_output.quadrature_loopback_bench import CASES
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    "are_long", [False, pytest.param(True, marks=pytest.mark.large)], ids=["short", "long"]
)
def test_quadrature_output(are_long: bool) -> None:
    chosen = [place for place, is_long in enumerate(LONG) if is_long is are_long]
    simulate(
        "quadrature_output",
        "tb.quadrature_output.quadrature_output_bench",
        testcase=[f"follows_the_model/name={place}" for place in chosen],
    )


LONG_CLOCKS = 3000
LONG = [
    sum(segment.clocks for segment in scenario.segments) > LONG_CLOCKS
    for scenario in SCENARIOS.values()
]
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
