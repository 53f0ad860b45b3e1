from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate

UNFOLDED = ("illegal_accesses_are_refused", "interrupt_of_a_swap_and_its_ramp")
"""Names of the tests whose results depend on the pipeline's lanes and latency.

``tb/top/test_arctrue_zynq_top.py`` takes edges through this core to corrected edges.
"""


@pytest.mark.parametrize(
    "testcase",
    [UNFOLDED, pytest.param(None, marks=pytest.mark.large)],
    ids=["lanes_and_latency", "all"],
)
def test_core(testcase: tuple[str, ...] | None) -> None:
    """In this core every lane has its own pipeline; ``make test-large`` runs all tests, here and in
    ``test_folded_core``."""
    simulate(
        "arctrue_core",
        "tb.core.arctrue_core_bench",
        generics={"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH},
        testcase=testcase,
    )


@pytest.mark.slow
@pytest.mark.parametrize("tests", ["quick", pytest.param("all", marks=pytest.mark.large)])
def test_folded_core(tests: str) -> None:
    """The core works with one pipeline for four lanes, and its registers state this fold.

    The quick tests leave out what other benches show: edges that are corrected
    (``test_core_with_a_table``), turns that a slow processor misses (``tb/sampler``), and an index
    that scatters (``tb/decoder``).
    """
    simulate(
        "arctrue_core",
        "tb.core.arctrue_core_bench",
        generics={"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH, "FOLD": 4},
        environment={"FOLD": "4", **({"QUICK": "yes"} if tests == "quick" else {})},
    )


def test_core_with_events() -> None:
    """With EVENTS, events of probe and compare wait for the processor, and a register states that
    the queue is built."""
    generics = {"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH, "EVENTS": "true"}
    simulate(
        "arctrue_core",
        "tb.core.arctrue_core_bench",
        generics=generics,
        testcase=("events_wait_for_the_processor", "illegal_accesses_are_refused"),
        environment={"EVENTS": "yes"},
    )


def test_core_with_a_table() -> None:
    """The data path works with ROTATION = table, and a register states this rotation."""
    generics = {"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH, "FOLD": 2, "ROTATION": "table"}
    simulate(
        "arctrue_core",
        "tb.core.arctrue_core_bench",
        generics=generics,
        testcase=("from_edges_to_corrected_edges", "illegal_accesses_are_refused"),
        environment={"FOLD": "2", "ROTATION": "table"},
    )
