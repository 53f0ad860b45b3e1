from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate

SHORTEST = (
    "correction_waits_for_the_index",
    "turn_length_and_rearm",
    "polarity_and_direction_of_the_pins/swaps=1",
    "alarm_and_release_of_the_drivers",
    "one_clear_brings_an_output_back_that_could_not_keep_up",
    "a_reset_of_the_core_does_not_drop_the_line_drivers",
    "faults_reach_the_processor",
    "illegal_accesses_are_refused",
    "interrupt_of_a_swap_and_its_ramp",
    "external_instruments",
)
"""Names of the tests that run without ``large``.

Other benches cover the remaining tests: corrected edges (``tb/top``), samples at equal angles and
turns that a slow processor misses (``tb/sampler``), index marks that scatter or are out of their
place (``tb/decoder``), and lost counts (``sim/tests/faults``). Only ``make test-large`` tests Z
before the index, a shorter turn, and edges that the filter swallows.
"""


@pytest.mark.large
def test_core() -> None:
    """A core with a pipeline for each lane passes the tests of the bench."""
    simulate(
        "arctrue_core",
        "tb.core.arctrue_core_bench",
        generics={"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH},
    )


@pytest.mark.parametrize(
    "testcase",
    [SHORTEST, pytest.param(None, marks=pytest.mark.large)],
    ids=["shortest", "all"],
)
def test_folded_core(testcase: tuple[str, ...] | None) -> None:
    """A core with one pipeline for four lanes passes the tests, and a register states its fold."""
    simulate(
        "arctrue_core",
        "tb.core.arctrue_core_bench",
        generics={"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH, "FOLD": 4},
        testcase=testcase,
        environment={"FOLD": "4"},
    )


@pytest.mark.large
def test_core_with_events() -> None:
    """With EVENTS, events of probe and compare wait in a queue for the processor, and a register
    states that the queue is built."""
    generics = {"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH, "EVENTS": "true"}
    simulate(
        "arctrue_core",
        "tb.core.arctrue_core_bench",
        generics=generics,
        testcase=("events_wait_for_the_processor", "illegal_accesses_are_refused"),
        environment={"EVENTS": "yes"},
    )


@pytest.mark.large
def test_core_with_a_table() -> None:
    """A core with ROTATION = table passes the tests of the data path, and a register states this
    rotation."""
    generics = {"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH, "FOLD": 2, "ROTATION": "table"}
    simulate(
        "arctrue_core",
        "tb.core.arctrue_core_bench",
        generics=generics,
        testcase=("from_edges_to_corrected_edges", "illegal_accesses_are_refused"),
        environment={"FOLD": "2", "ROTATION": "table"},
    )
