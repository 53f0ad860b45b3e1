"""Tests that a board corrects again after power off and on without any command."""

from __future__ import annotations

import pytest
from sim.tests.faults.conftest import MakeScene
from sim.tests.faults.scene import Scene

from arctrue.instrument import InstrumentError


def test_what_is_saved_corrects_again_within_a_captured_turn(
    scene: Scene, make_scene: MakeScene
) -> None:
    """After power-on, the saved coefficients correct again within a captured turn. The test starts
    another instrument, with empty banks and registers, from the flash content alone."""
    before = scene.bank()
    assert scene.firmware.send("save") == ""
    while not (answer := scene.firmware.step()):
        pass
    assert answer.startswith("ok, record 1: parameters and ")
    again = make_scene(flash=scene.firmware.flash)
    assert again.firmware.coefficients is None
    assert "saved waiting" in again.firmware.send("status").splitlines()
    # The table passes the index of both heads and one captured turn, which confirms the
    # coefficients. Telemetry is on, because the saved settings include it.
    again.calibrate()
    assert len(again.firmware.telemetry) <= 2
    assert again.bank() == before
    assert "saved confirmed" in again.firmware.send("status").splitlines()


def test_an_empty_flash_leaves_the_presets(make_scene: MakeScene, scene: Scene) -> None:
    """With an empty flash the firmware starts with the presets, which are for another number of
    counts. The instrument refuses a flash content of another size."""
    empty = b"\xff" * len(scene.firmware.flash)
    assert scene.firmware.flash == empty
    bare = make_scene(flash=empty)
    assert "settings preset" in bare.firmware.send("status").splitlines()
    with pytest.raises(InstrumentError, match="bytes"):
        make_scene(flash=b"")
