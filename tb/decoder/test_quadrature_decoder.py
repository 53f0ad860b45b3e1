"""Runs the bench of the quadrature decoder in GHDL."""

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("stages", "reset_position"),
    [
        pytest.param(2, 0, marks=pytest.mark.large),
        (3, 2**31 - 25),
        pytest.param(4, -(2**31) + 25, marks=pytest.mark.large),
    ],
)
def test_quadrature_decoder(stages: int, reset_position: int) -> None:
    generics = {"SYNCHRONISER_STAGES": stages, "RESET_POSITION": reset_position}
    simulate(
        "quadrature_decoder",
        "tb.decoder.quadrature_decoder_bench",
        generics=generics,
        environment={name: str(value) for name, value in generics.items()},
    )
