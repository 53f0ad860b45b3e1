"""Runs the benches of the small units between the core and its pins in GHDL."""

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    "entity",
    ["input_selection", "pulse_input", "pulse_output", "position_compare"],
)
def test_unit(entity: str) -> None:
    simulate(entity, f"tb.signals.{entity}_bench")


def test_fault_outputs() -> None:
    hold_log2 = 5
    simulate(
        "fault_outputs",
        "tb.signals.fault_outputs_bench",
        generics={"HOLD_LOG2": hold_log2},
        environment={"HOLD": str(2**hold_log2)},
    )


@pytest.mark.parametrize(
    ("depth_log2", "delay", "compare_delay"),
    [pytest.param(1, 2, 3, marks=pytest.mark.large), (3, 30, 35)],
)
def test_event_queue(depth_log2: int, delay: int, compare_delay: int) -> None:
    generics = {"DEPTH_LOG2": depth_log2, "DELAY": delay, "COMPARE_DELAY": compare_delay}
    simulate(
        "event_queue",
        "tb.signals.event_queue_bench",
        generics=generics,
        environment={name: str(value) for name, value in generics.items()},
    )


@pytest.mark.parametrize("delay", [pytest.param(2, marks=pytest.mark.large), 30])
def test_position_latch(delay: int) -> None:
    simulate(
        "position_latch",
        "tb.signals.position_latch_bench",
        generics={"DELAY": delay},
        environment={"DELAY": str(delay)},
    )
