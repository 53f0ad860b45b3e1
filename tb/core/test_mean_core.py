"""Runs in GHDL the bench of the whole core with the weighted mean of two to four heads."""

from __future__ import annotations

import pytest

from tb.core.mean_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("heads", "carriers"),
    [
        (4, "4"),
        pytest.param(2, "1 2", marks=pytest.mark.large),
        pytest.param(3, "1 2 3", marks=pytest.mark.large),
        pytest.param(4, "1 2 3 4", marks=pytest.mark.large),
    ],
)
def test_mean_core(heads: int, carriers: str) -> None:
    simulate(
        "arctrue_core",
        "tb.core.mean_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "HEADS": heads,
            "MEAN": "true",
        },
        environment={"HEADS": str(heads), "CARRIERS": carriers},
    )
