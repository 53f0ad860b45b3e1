"""Tests the position compare with a single place and with an interval, set on the console."""

from __future__ import annotations

from sim.tests.faults.scene import Scene
from sim.tests.faults.setting import CLOCKS_A_COUNT, COUNTS

LOOK_CLOCKS = 20 * CLOCKS_A_COUNT
"""Clocks between two reads of the compare's status."""


def corrected_angle(scene: Scene) -> int:
    scene.instrument.read("snapshot.time")
    return int(scene.instrument.read("snapshot.corrected_angle"))


def test_the_compare_is_done_where_the_console_said() -> None:
    """When the core reports that the compare is done, the corrected angle is beyond the compare
    place by at most the travel in two intervals between reads of the status."""
    scene = Scene()
    scene.calibrate()
    place = (corrected_angle(scene) + COUNTS // 4) % COUNTS
    for line in (f"compare first {place}", "compare on 1"):
        assert scene.firmware.send(line) == "ok"
    assert "armed yes" in scene.firmware.send("compare")
    scene.firmware.run(
        until=lambda _: not scene.instrument.read("status.compare_armed"), poll_clocks=LOOK_CLOCKS
    )
    passed = (corrected_angle(scene) - place) % COUNTS
    assert passed <= 2 * LOOK_CLOCKS // CLOCKS_A_COUNT
    assert "armed no" in scene.firmware.send("compare")
    # An interval compare continues until the operator ends it.
    assert scene.firmware.send(f"compare interval {COUNTS // 8}") == "ok"
    scene.turn(0.5)
    assert "armed yes" in scene.firmware.send("compare")
    assert scene.firmware.send("compare on 0") == "ok"
    assert "armed no" in scene.firmware.send("compare")
