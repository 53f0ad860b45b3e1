"""Runs the bench of the edge counter in GHDL."""

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize("reset_position", [0, pytest.param(2**31 - 100, marks=pytest.mark.large)])
def test_edge_counter(reset_position: int) -> None:
    generics = {"RESET_POSITION": reset_position}
    simulate(
        "edge_counter",
        "tb.decoder.edge_counter_bench",
        generics=generics,
        environment={name: str(value) for name, value in generics.items()},
    )
