"""Tests that the weighted mean minus the reading of the carrier (the term) equals its model in
VHDL, for two to four heads."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize("heads", [2, 3, 4])
def test_weighted_mean(heads: int) -> None:
    simulate(
        "weighted_mean",
        "tb.mean.weighted_mean_bench",
        generics={"HEADS": heads},
        environment={"HEADS": str(heads)},
    )
