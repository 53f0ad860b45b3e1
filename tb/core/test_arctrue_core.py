from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate

UNFOLDED = (
    "from_edges_to_corrected_edges",
    "illegal_accesses_are_refused",
    "interrupt_of_a_swap_and_its_ramp",
)
"""Tests in which the pipeline's lanes and latency matter."""


@pytest.mark.parametrize("testcase", [*UNFOLDED, pytest.param(None, marks=pytest.mark.large)])
def test_core(testcase: str | None) -> None:
    """Every lane has a pipeline; ``make test-large`` runs all tests, as ``test_folded_core``
    does."""
    simulate(
        "arctrue_core",
        "tb.core.arctrue_core_bench",
        generics={"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH},
        testcase=testcase,
        backend="llvm",
    )


@pytest.mark.slow
def test_folded_core() -> None:
    """The core has one pipeline for four lanes, and registers that state it."""
    simulate(
        "arctrue_core",
        "tb.core.arctrue_core_bench",
        generics={"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH, "FOLD": 4},
        environment={"FOLD": "4"},
        backend="llvm",
    )


def test_core_with_events() -> None:
    """Events of probe and compare wait for the processor with EVENTS, and a register states it."""
    generics = {"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH, "EVENTS": "true"}
    for testcase in ("events_wait_for_the_processor", "illegal_accesses_are_refused"):
        simulate(
            "arctrue_core",
            "tb.core.arctrue_core_bench",
            generics=generics,
            testcase=testcase,
            environment={"EVENTS": "yes"},
            backend="llvm",
        )


def test_core_with_a_table() -> None:
    """The data path works with ROTATION = table, and a register states it."""
    generics = {"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH, "FOLD": 2, "ROTATION": "table"}
    for testcase in ("from_edges_to_corrected_edges", "illegal_accesses_are_refused"):
        simulate(
            "arctrue_core",
            "tb.core.arctrue_core_bench",
            generics=generics,
            testcase=testcase,
            environment={"FOLD": "2", "ROTATION": "table"},
            backend="llvm",
        )
