"""Tests that the phases of all lanes in VHDL equal their model."""

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("lanes", "angles"),
    [
        pytest.param(1, 500, marks=pytest.mark.large),
        (3, 500),
        pytest.param(32, 400, marks=pytest.mark.large),
        pytest.param(64, 200, marks=pytest.mark.large),
    ],
)
def test_phase_unit(lanes: int, angles: int) -> None:
    simulate(
        "phase_unit",
        "tb.phase.phase_unit_bench",
        generics={"LANES": lanes},
        environment={"LANES": str(lanes), "ANGLES": str(angles)},
    )
