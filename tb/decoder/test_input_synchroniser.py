"""Runs the bench of the input synchroniser in GHDL."""

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("width", "stages"), [(3, 2), (1, 3), pytest.param(5, 4, marks=pytest.mark.large)]
)
def test_input_synchroniser(width: int, stages: int) -> None:
    generics = {"WIDTH": width, "STAGES": stages}
    simulate(
        "input_synchroniser",
        "tb.decoder.input_synchroniser_bench",
        generics=generics,
        environment={name: str(value) for name, value in generics.items()},
    )
