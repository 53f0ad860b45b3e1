"""Adder tree, ramp and subtraction in VHDL equal their models, bit by bit."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize("lanes", [1, 4, 9, 32, 64])
def test_error_compensation(lanes: int) -> None:
    """All numbers of groups in the adder tree, and an odd number of lanes."""
    simulate(
        "error_compensation",
        "tb.compensation.error_compensation_bench",
        generics={"LANES": lanes},
        environment={"LANES": str(lanes)},
    )
