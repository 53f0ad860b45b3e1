"""Tests the consequences if a head gives no signals, because a cable is pulled or a supply
fails."""

from __future__ import annotations

import pytest
from sim.tests.faults.conftest import MakeScene
from sim.tests.faults.scene import Scene
from sim.tests.faults.setting import CLOCKS_A_COUNT, COUNTS, PERIOD_COUNTS

from arctrue.instrument import HEAD1_A, HEAD1_B, HEAD1_Z, HEAD2_A, HEAD2_B, HEAD2_Z, PinFault

HEAD1 = HEAD1_A | HEAD1_B | HEAD1_Z
DEAD_TURNS = 4.75
"""Duration of the fault in turns. It is no whole number: after a whole number of turns the angle
would be right again, and no index would show the fault."""
HEAD2 = HEAD2_A | HEAD2_B | HEAD2_Z


@pytest.mark.parametrize("level", [pytest.param("low", marks=pytest.mark.large), "high"])
def test_head_2_dead(scene: Scene, level: str) -> None:
    """While head 2 is dead, the correction continues with the active coefficients."""
    before, turns = scene.bank(), len(scene.firmware.telemetry)
    scene.disturb(3.2, **{level: HEAD2})
    scene.turn(3.0)
    assert len(scene.firmware.telemetry) >= turns + 3
    results = {reply["result"] for reply in scene.firmware.telemetry[turns:]}
    assert "refused" in results <= {"refused", "alarm"}
    assert scene.last_reply["reason"] == "stands_still"
    assert scene.bank() == before
    scene.is_clean()
    scene.turn(1.0)
    scene.recovers()
    # The missed edges shift the head's zero. The firmware reports the lost zero and uses the new
    # one.
    assert any("zero_lost" in reply["alarms"] for reply in scene.firmware.telemetry[turns:])
    assert scene.last_reply["alarms"] == []
    scene.knows_the_separation()


@pytest.mark.parametrize(
    "level",
    [
        pytest.param("held", marks=pytest.mark.large),
        pytest.param("low", marks=pytest.mark.large),
        "high",
    ],
)
def test_head_1_dead(scene: Scene, level: str) -> None:
    """The output follows head 1: it stops when head 1 stops, and continues without a jump when head
    1 returns."""
    before, turns = scene.bank(), len(scene.firmware.telemetry)
    if level == "held":
        scene.drop(round(DEAD_TURNS * COUNTS), also_low=HEAD1_Z)
    else:
        scene.disturb(DEAD_TURNS, **{level: HEAD1})
    scene.turn(0.1)
    scene.record()
    scene.turn(DEAD_TURNS - 0.5)
    dead = scene.instrument.recording()
    assert dead.head1.edges == dead.illegal == 0
    # If Z is held high, the decoder detects an index and the correction ramps to 0, which moves the
    # output; in the other cases the output does not move.
    assert dead.output.edges <= (scene.largest_correction if level == "high" else 0)
    assert scene.last_reply["result"] == "refused"
    assert scene.bank() == before

    scene.record()
    scene.turn(1.0)
    lost = scene.compare()
    assert lost.illegal == 0
    assert lost.most_slip > (DEAD_TURNS - 1) * COUNTS
    assert lost.worse < scene.clean_bound + scene.wrong_place(lost.most_slip) + scene.ramp_lag
    scene.turn(1.5)
    reasons = scene.reasons(turns)
    # A turn is refused because of a flag, or because the bank is full before the turn has passed.
    # Whether a dead head sets a flag depends on the place at which it dies or returns, because A
    # and B must change together for a flag.
    flags = {"illegal_transition", "edge_spacing", "index_error"}
    assert reasons[0] in {"bank_full"} | (set() if level == "held" else flags)
    assert "index_error" in reasons
    assert any("zero_lost" in reply["alarms"] for reply in scene.firmware.telemetry[turns:])
    scene.recovers()


@pytest.mark.parametrize(
    "back_after",
    [
        0,
        *(pytest.param(place, marks=pytest.mark.large) for place in range(1, PERIOD_COUNTS)),
    ],
)
@pytest.mark.parametrize("pins", [HEAD1, HEAD2])
def test_head_dead_from_the_start(make_scene: MakeScene, pins: int, back_after: int) -> None:
    """A head is dead from the start and returns at any place. Until the indices are found, the
    output repeats head 1 without a correction."""
    scene = make_scene(None, None, PinFault(0, 1 << 40, low=pins))
    scene.record()
    scene.turn(2.0)
    assert scene.firmware.phase == "wait_for_index"
    assert not scene.firmware.telemetry
    assert scene.instrument.read("status.compensating") == 0
    recording = scene.instrument.recording()
    assert abs(recording.output.edges - recording.head1.edges) <= 2
    assert recording.illegal == 0
    scene.instrument.run(back_after * CLOCKS_A_COUNT)
    scene.instrument.disturb()
    scene.turn(0.01)
    assert scene.firmware.phase == "wait_for_index"
    # As in the test above, the place at which the head returns determines whether it sets a flag.
    flags = scene.faults()
    head = "head1" if pins == HEAD1 else "head2"
    reasons = {f"{head}.illegal": "illegal_transition", f"{head}.overspeed": "edge_spacing"}
    assert flags <= set(reasons)
    scene.calibrate(next((why for flag, why in reasons.items() if flag in flags), None))
