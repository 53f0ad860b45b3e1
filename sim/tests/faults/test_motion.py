"""Tests a table that reverses within a turn, one that turns too fast, and one whose speed
varies."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.faults.conftest import MakeScene
from sim.tests.faults.setting import (
    CLOCKS_A_COUNT,
    COUNTS,
    FOLLOWING_LIMIT_COUNTS,
    MINIMUM_EDGE_SPACING_CLOCKS,
    OUTPUT_SPACING_CLOCKS,
    RUN_UP_S,
    SPEED_RAD_S,
    START_RAD,
    TURN_RAD,
    TURN_S,
    legs,
)

from arctrue.table import Motion

HYSTERESIS_COUNTS = 1
"""Number of counts that the output does not follow at a reversal."""


def test_reversal(make_scene: MakeScene) -> None:
    scene = make_scene(legs((1, 3.6), (-1, 4.0), (1, 4.0)))
    scene.calibrate()
    scene.to_part(0.3)
    scene.record()
    before = scene.bank()
    while (reply := scene.next_turn())["result"] != "refused":
        before = scene.bank()
    assert reply["reason"] in ("reversal", "wrong_step")
    assert scene.bank() == before
    # A reversal is no fault of the signals and sets no flag.
    assert not scene.faults()
    during = scene.compare()
    assert during.illegal == 0
    assert during.most < scene.clean_bound + HYSTERESIS_COUNTS
    # The firmware also uses a turn in the other direction.
    assert scene.next_turn()["result"] != "refused"
    scene.settle()
    scene.record()
    scene.turn(0.8)
    assert scene.compare().most < scene.clean_bound + HYSTERESIS_COUNTS


@pytest.mark.parametrize(
    "speed",
    [2.5, pytest.param(4.0, marks=pytest.mark.large), pytest.param(8.0, marks=pytest.mark.large)],
)
def test_over_speed(make_scene: MakeScene, speed: float) -> None:
    """The core reports edges of head 1 that are closer than permitted, faster than the output, or
    more than one per clock.

    Only the fault of the output switches the line drivers off.
    """
    fast_s_turns = 0.02
    scene = make_scene(legs((1, 2.7), (speed, fast_s_turns), (1, 12.0)), {"release_sources": 4})
    scene.calibrate()
    scene.to_part(0.3)
    turns, before = len(scene.firmware.telemetry), scene.bank()
    scene.record()
    assert 2.25 < scene.instrument.true_angle_rad / TURN_RAD < 2.55
    scene.turn(0.6)
    clocks_a_count = CLOCKS_A_COUNT / speed
    assert clocks_a_count < MINIMUM_EDGE_SPACING_CLOCKS
    flags = scene.faults()
    # The decoder interprets two counts in one clock as an illegal transition.
    assert ("head1.illegal" in flags) == (clocks_a_count < 1)
    assert "head1.overspeed" in flags
    assert ("cannot_keep_up" in flags) == (clocks_a_count < OUTPUT_SPACING_CLOCKS)
    during = scene.compare()
    assert during.illegal == 0
    output_fault = clocks_a_count < OUTPUT_SPACING_CLOCKS
    # Beyond the following limit the output stops: it makes no further edges although the head moves
    # on.
    limit = FOLLOWING_LIMIT_COUNTS if output_fault else 0
    late = (OUTPUT_SPACING_CLOCKS + 1) / clocks_a_count
    wrong = scene.wrong_place(during.most_slip)
    assert during.worse < scene.clean_bound + late + limit + wrong
    assert (during.edges < 0.5 * COUNTS) == output_fault

    assert scene.next_turn()["result"] == "refused"
    if output_fault:
        released = scene.firmware.telemetry[turns]
        assert (released["result"], released["alarms"]) == ("alarm", ["output"]), "reported at once"
        turns += 1
    assert scene.reasons(turns)[0] in ("edge_spacing", "illegal_transition", "index_error")
    assert ("output" in scene.last_reply["alarms"]) == output_fault
    assert (scene.last_reply["output_fault"] == "cannot_keep_up") == output_fault
    assert scene.last_reply["released"] == (["cannot_keep_up"] if output_fault else [])
    assert scene.bank() == before
    scene.record()
    scene.turn(0.4)
    # After the refused turn the firmware has cleared the flags of the heads; the output is still
    # stopped.
    assert (scene.compare().edges == 0) == output_fault
    assert scene.instrument.read("status.released") == output_fault
    scene.recovers(refers=output_fault)
    assert not scene.instrument.read("status.released"), (
        "clear_output also enables the line drivers"
    )


@pytest.mark.large
def test_a_speed_that_swings_is_calibrated_at_equal_angles(make_scene: MakeScene) -> None:
    """At a speed ripple of ±15 %, five times per turn, the firmware refuses samples at equal times
    and uses samples at equal angles.

    The bound is the one for constant speed.
    """
    times = np.arange(0.0, 12.0 * TURN_S, TURN_S / 200.0) + RUN_UP_S
    speeds = SPEED_RAD_S * (1.0 + 0.15 * np.sin(5.0 * 2.0 * np.pi * times / TURN_S))
    motion = Motion((0.0, *times.tolist()), (0.0, *speeds.tolist()), START_RAD)
    swinging = make_scene(motion)
    swinging.calibrate(flag_reason="wrong_step")
    assert "samples equal_angles" in swinging.firmware.send("status").splitlines()
    assert set(swinging.reasons(2)) <= {"none", "not_better"}
