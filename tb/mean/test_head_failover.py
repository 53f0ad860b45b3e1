"""Tests that head_failover chooses sets, readmits heads and refuses words like its model."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize("heads", [pytest.param(3, marks=pytest.mark.large), 4])
def test_head_failover(heads: int) -> None:
    simulate(
        "head_failover",
        "tb.mean.head_failover_bench",
        generics={"HEADS": heads, "INTERVAL_BITS": 5},
        environment={"HEADS": str(heads), "INTERVAL_BITS": "5"},
    )
