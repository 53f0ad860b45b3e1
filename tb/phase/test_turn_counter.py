"""Tests that turn numbers in VHDL equal their model."""

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("counts_per_rev", "fold"),
    [
        (4096, 1),
        pytest.param(5001, 4, marks=pytest.mark.large),
        pytest.param(2**24, 1, marks=pytest.mark.large),
    ],
)
def test_turn_counter(counts_per_rev: int, fold: int) -> None:
    simulate(
        "turn_counter",
        "tb.phase.turn_counter_bench",
        environment={"COUNTS_PER_REV": str(counts_per_rev), "FOLD": str(fold)},
    )
