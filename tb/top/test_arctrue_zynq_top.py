from __future__ import annotations

import pytest

from tb.support.simulation import simulate
from tb.top.arctrue_zynq_bench import CAPTURE_DEPTH, LANES, LED_HOLD_LOG2

GENERICS = {
    "LANES": LANES,
    "CAPTURE_DEPTH": CAPTURE_DEPTH,
    "LED_HOLD_LOG2": LED_HOLD_LOG2,
    "FOLD": 1,
}


@pytest.mark.parametrize(
    "tests",
    [
        "registers|from_edges|i2c|identified|leds|interrupt",
        pytest.param("reset_in_the_middle", marks=pytest.mark.large),
    ],
    ids=["pins", "reset"],
)
def test_top_level(tests: str) -> None:
    simulate(
        "arctrue_zynq_harness",
        "tb.top.arctrue_zynq_bench",
        generics=GENERICS,
        environment={"COCOTB_TEST_FILTER": tests},
    )


def test_four_heads_reach_the_core() -> None:
    simulate(
        "arctrue_zynq_heads_harness",
        "tb.top.arctrue_zynq_heads_bench",
        generics={**GENERICS, "HEADS": 4},
        environment={"HEADS": "4"},
    )


def test_pairs_reach_the_top_level() -> None:
    simulate(
        "arctrue_zynq_differential_harness",
        "tb.top.arctrue_zynq_bench",
        generics={**GENERICS, "FOLD": 2},
        environment={
            "ARCTRUE_PAIRS": "1",
            "ARCTRUE_FOLD": "2",
            "COCOTB_TEST_FILTER": "registers|from_edges|i2c|identified",
        },
    )
