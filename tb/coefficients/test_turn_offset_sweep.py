"""Tests that the VHDL computes the phase offset of each turn as the model does."""

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("lanes", "fold"),
    [
        (4, 1),
        pytest.param(6, 2, marks=pytest.mark.large),
        pytest.param(32, 8, marks=pytest.mark.large),
    ],
)
def test_turn_offset_sweep(lanes: int, fold: int) -> None:
    simulate(
        "turn_offset_sweep",
        "tb.coefficients.turn_offset_sweep_bench",
        generics={"LANES": lanes, "FOLD": fold},
        environment={"LANES": str(lanes), "FOLD": str(fold)},
    )
