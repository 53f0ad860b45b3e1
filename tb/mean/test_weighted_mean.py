"""Tests that the term of the weighted mean (the carrier's reading minus the mean) in VHDL equals
its model, for two to four heads."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    "heads", [pytest.param(2, marks=pytest.mark.large), pytest.param(3, marks=pytest.mark.large), 4]
)
def test_weighted_mean(heads: int) -> None:
    simulate(
        "weighted_mean",
        "tb.mean.weighted_mean_bench",
        generics={"HEADS": heads},
        environment={"HEADS": str(heads)},
    )
