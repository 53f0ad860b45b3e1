"""Tests that random delays on every channel of the AXI bus change no result."""

from __future__ import annotations

import pytest
from sim.tests.faults.conftest import MakeScene
from sim.tests.faults.scene import Scene


@pytest.mark.large
def test_stalls_delay_and_change_nothing(make_scene: MakeScene) -> None:
    """A turn gives the same coefficients over a fast and over a slow bus."""
    banks = []
    for stall in (0, 20):
        scene = make_scene()
        scene.firmware.run(until=lambda f: f.phase == "capture", poll_clocks=500)
        assert scene.instrument.run_until(interrupt=True) == "interrupt"
        scene.instrument.stall_bus(stall)
        begin = scene.instrument.clock
        scene.next_turn()
        banks.append((scene.bank(), scene.instrument.clock - begin))
    assert banks[0][0] == banks[1][0]
    assert banks[1][1] > 2 * banks[0][1]


def test_bus_slower_than_the_table(scene: Scene) -> None:
    """If the bus is slower than the table, the gateware drops and counts turns; each captured turn
    is complete."""
    turns = len(scene.firmware.telemetry)
    scene.instrument.stall_bus(120)
    scene.turn(4.0)
    assert scene.instrument.read("overrun_count") > 0
    assert any("overrun" in reply["alarms"] for reply in scene.firmware.telemetry[turns:])
    assert set(scene.reasons(turns)) <= {"none", "not_better"}
    scene.is_clean()
    scene.instrument.stall_bus(0)
    scene.recovers()
