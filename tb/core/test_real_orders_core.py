"""Runs in GHDL the bench of the whole core with lanes whose orders are not integers (real orders).

``test_compensation_pipeline.py`` compares the output of the pipeline, with a circuit for each lane,
with the model in every clock.
"""

from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("fold", "testcase"),
    [
        (4, ("rearm_keeps_the_turn", "words_of_turn_steps")),
        pytest.param(1, None, marks=pytest.mark.large),
        pytest.param(4, None, marks=pytest.mark.large),
    ],
    ids=["4-turn", "1-all", "4-all"],
)
def test_core_with_real_orders(fold: int, testcase: tuple[str, ...] | None) -> None:
    simulate(
        "arctrue_core",
        "tb.core.real_orders_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "FOLD": fold,
            "REAL_ORDERS": "true",
        },
        testcase=testcase,
        environment={"FOLD": str(fold)},
    )
