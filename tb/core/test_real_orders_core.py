"""Runs in GHDL the bench of the whole core with lanes whose orders are not integers (real orders).

``test_compensation_pipeline.py`` compares the output of the pipeline, with a circuit for each lane,
with the model in every clock.
"""

from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.parametrize("fold", [pytest.param(1, marks=pytest.mark.large), 4])
def test_core_with_real_orders(fold: int) -> None:
    simulate(
        "arctrue_core",
        "tb.core.real_orders_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "FOLD": fold,
            "REAL_ORDERS": "true",
        },
        environment={"FOLD": str(fold)},
    )
