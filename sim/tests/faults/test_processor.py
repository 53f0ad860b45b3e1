"""Tests that the output stays right while the processor hangs, is slow, restarts or gets no
capture."""

from __future__ import annotations

import pytest
from sim.tests.faults.scene import Scene
from sim.tests.faults.setting import POLL_CLOCKS, TURN_CLOCKS


def test_hung_for_three_turns(scene: Scene) -> None:
    """While the processor hangs, the gateware continues with the active coefficients and drops
    turns."""
    before = scene.bank()
    scene.instrument.run(3 * TURN_CLOCKS)
    assert scene.instrument.read("status.capture_ready") == 1
    assert scene.instrument.read("overrun_count") == 2
    assert scene.instrument.read("interrupt_status.capture_overrun") == 1
    scene.is_clean()
    assert scene.bank() == before
    assert "overrun" in scene.next_turn()["alarms"]
    scene.recovers()


@pytest.mark.large
def test_calculation_longer_than_a_turn(scene: Scene) -> None:
    """During a long calculation the sampler does not write into the bank that the firmware
    reads."""
    scene.firmware.calculation_clocks = round(2.5 * TURN_CLOCKS)
    begin = scene.instrument.clock
    scene.next_turn()
    assert scene.instrument.clock - begin > 2.5 * TURN_CLOCKS
    assert scene.last_reply["result"] != "refused"
    assert "overrun" in scene.last_reply["alarms"]
    scene.is_clean()
    scene.firmware.calculation_clocks = 0
    scene.recovers()


def test_begins_anew_after_a_fault(scene: Scene) -> None:
    """After a restart of the firmware (a fault, or the watchdog) the core continues with its active
    coefficients."""
    clean = scene.clean_bound
    position = scene.instrument.read("head1.index.position")
    scene.firmware.fault()
    assert scene.firmware.coefficients is None, "the firmware has lost them"
    assert scene.firmware.send("status").count("compensation on") == 1
    compensating = []
    replies = len(scene.firmware.telemetry)
    scene.firmware.run(
        until=lambda f: (
            compensating.append(scene.instrument.read("status.compensating"))
            or len(f.telemetry) > replies
        ),
        poll_clocks=POLL_CLOCKS,
    )
    assert all(compensating)
    assert "began_anew" in scene.last_reply["alarms"]
    during = scene.compare()
    assert during.most < clean
    assert during.illegal == 0
    assert scene.instrument.read("head1.index.position") != position
    assert scene.last_reply["result"] == "applied"
    assert scene.firmware.coefficients is not None
    scene.recovers()


@pytest.mark.large
def test_begins_anew(scene: Scene) -> None:
    """After a re-arm the correction ramps to 0 and stays 0 until the firmware has calibrated
    again."""
    scene.firmware.start()
    assert scene.firmware.phase == "wait_for_index"
    assert scene.firmware.coefficients is None
    assert scene.instrument.read("control.compensate") == 0
    clean = scene.clean_bound
    scene.turn(0.6)
    assert scene.instrument.read("status.ramp_busy") == 0
    anew = scene.compare()
    assert anew.illegal == 0
    assert not scene.faults()
    assert scene.next_turn()["result"] == "applied"
    assert anew.worse < clean + scene.ramp_lag
    scene.recovers()


@pytest.mark.large
def test_capture_that_is_stuck(scene: Scene) -> None:
    """If the capture is switched off, the firmware starts it again after four turns without a
    bank."""
    lag = scene.ramp_lag
    scene.instrument.update("control", capture_enable=0)
    scene.next_turn()
    assert scene.last_reply["alarms"] == ["stuck_capture"]
    assert scene.firmware.coefficients is None
    scene.turn(0.5)
    during = scene.compare()
    assert during.illegal == 0
    assert during.worse < scene.clean_bound + lag
    assert scene.next_turn()["result"] == "applied"
    scene.recovers()
