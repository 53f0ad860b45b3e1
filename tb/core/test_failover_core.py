"""The whole core leaves a failed head out of the mean of three and of four heads."""

from __future__ import annotations

import pytest

from tb.core.mean_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.parametrize("heads", [pytest.param(3, marks=pytest.mark.large), 4])
def test_failover_core(heads: int) -> None:
    simulate(
        "arctrue_core",
        "tb.core.failover_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "HEADS": heads,
            "FAILOVER": "true",
        },
        environment={"HEADS": str(heads), "ANY_HEAD_MAY_FAIL": "yes"},
        backend="llvm",
    )
