"""Tests that the VHDL finds the failed head and computes the parity (a weighted sum of the
readings) of all heads as the models do."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize("heads", [pytest.param(3, marks=pytest.mark.large), 4])
def test_head_watch(heads: int) -> None:
    simulate(
        "head_watch",
        "tb.mean.head_watch_bench",
        generics={"HEADS": heads, "INTERVAL_BITS": 5},
        environment={"HEADS": str(heads), "INTERVAL_BITS": "5"},
    )


@pytest.mark.parametrize("heads", [pytest.param(3, marks=pytest.mark.large), 4])
def test_parity_sum(heads: int) -> None:
    simulate(
        "parity_sum",
        "tb.mean.parity_sum_bench",
        generics={"HEADS": heads},
        environment={"HEADS": str(heads)},
    )
