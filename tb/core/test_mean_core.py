"""Runs in GHDL the bench of the whole core with the weighted mean of two to four heads."""

from __future__ import annotations

import pytest

from tb.core.mean_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("heads", "carriers", "testcase"),
    [
        (4, "4", "the_mean_is_blind_to_the_axis"),
        pytest.param(2, "1 2", None, marks=pytest.mark.large),
        pytest.param(3, "1 2 3", None, marks=pytest.mark.large),
        pytest.param(4, "1 2 3 4", None, marks=pytest.mark.large),
    ],
)
def test_mean_core(heads: int, carriers: str, testcase: str | None) -> None:
    simulate(
        "arctrue_core",
        "tb.core.mean_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "HEADS": heads,
            "MEAN": "true",
        },
        testcase=testcase,
        environment={"HEADS": str(heads), "CARRIERS": carriers},
    )
