"""Test of the whole core with the weighted mean of two to four heads."""

from __future__ import annotations

import pytest

from tb.core.mean_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    "heads", [pytest.param(2, marks=pytest.mark.large), pytest.param(3, marks=pytest.mark.large), 4]
)
def test_mean_core(heads: int) -> None:
    simulate(
        "arctrue_core",
        "tb.core.mean_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "HEADS": heads,
            "MEAN": "true",
        },
        environment={"HEADS": str(heads)},
        backend="llvm",
    )
