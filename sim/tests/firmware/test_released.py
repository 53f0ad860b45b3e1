"""Tests that console and telemetry report which fault disabled the line drivers, and that the
operator can enable them again."""

from __future__ import annotations

import json

import pytest
from sim.tests.firmware.model_core import FAULTS, Firmware, ModelCore, address, bit
from sim.tests.firmware.test_application import running, slipped, turn

__all__ = ["running"]

FOLLOWS = "ok, the output follows from the present position\r\n"
DRIVEN = "ok, the line drivers are enabled again\r\n"


def releases(running: Firmware, name: str) -> None:
    """Select the fault ``name`` in ``release_sources`` and raise this fault."""
    running.send(f"set release_sources {1 << FAULTS.index(name)}")
    if name == "cannot_keep_up":
        running.core.set("status", bit("status", name))
    elif name in ("head1", "head2"):
        running.core.set(f"{name}.flags", 0b0101)
    elif name == "swallowed":
        running.core.set("head1.flags", 0b1001 | bit("head1.flags", "swallowed"))
    else:
        running.core.lasting_faults = {name}
    running.send("telemetry on")


@pytest.mark.parametrize("name", FAULTS)
def test_one_command_brings_the_drivers_back(running: Firmware, name: str) -> None:
    """The command clear_output enables the line drivers again. It does not end the faults
    correction_limited and processor_silent: they end by themselves, and until then the command is
    refused."""
    assert "released none\r\n" in running.send("status")
    releases(running, name)
    telemetry = json.loads(running.step(2))
    assert (telemetry["result"], telemetry["alarms"]) == ("alarm", ["output"])
    assert telemetry["released"] == [name]
    assert running.step(3) == "", "reported once"
    said = running.send("status")
    assert f"released {name}, still present\r\nadvice the line drivers" in said
    if running.core.lasting_faults:
        answer = running.send("clear_output")
        assert answer == (
            f"error: the line drivers stay released, still present: {name}; try help released\r\n"
        )
        running.core.lasting_faults = set()
        assert f"released {name}\r\n" in running.send("status")
    assert running.send("clear_output") == (FOLLOWS if name == "cannot_keep_up" else DRIVEN)
    assert "released none\r\n" in running.send("status")
    assert running.send("clear_output") == "error: the output has no fault\r\n"
    assert running.turn(turn())["released"] == []
    releases(running, name)
    assert running.step(2) != "", "a release that comes again is reported again"


def test_nothing_else_brings_the_drivers_back(running: Firmware) -> None:
    releases(running, "head1")
    running.step(2)
    running.send("rearm")
    running.core.see_index()
    running.step(3)
    running.turn(turn())
    running.send("forget")
    running.step(3)
    assert "released head1\r\n" in running.send("status")
    assert running.send("clear_output") == DRIVEN


def test_each_turn_tells_that_the_drivers_are_released(running: Firmware) -> None:
    releases(running, "processor_silent")
    running.step(2)
    telemetry = running.turn(turn())
    assert telemetry["released"] == ["processor_silent"]
    assert telemetry["output_fault"] == "none"
    assert "output" in telemetry["alarms"]


def test_all_causes_are_reported_and_only_what_stands_is_named_as_such(running: Firmware) -> None:
    running.send("set release_sources 31")
    running.core.set("head2.flags", 0b0011)
    running.core.lasting_faults = {"correction_limited", "processor_silent"}
    said = running.send("status")
    for name in ("head2", "correction_limited", "processor_silent"):
        assert f"released {name}, still present\r\n" in said
    running.core.lasting_faults = {"correction_limited"}
    answer = running.send("clear_output")
    assert answer.startswith("error: the line drivers stay released, still present: correction_lim")
    assert running.core.get("head2.flags") == 1, "the flag of the head was cleared with it"
    said = running.send("status")
    assert "released correction_limited, still present\r\n" in said
    assert "released processor_silent" not in said


def test_flags_of_a_head_are_cleared_only_where_they_hold_the_release(running: Firmware) -> None:
    releases(running, "cannot_keep_up")
    running.core.set("head1.flags", 0b0101)
    running.core.writes.clear()
    running.send("clear_output")
    assert running.core.writes == [(address("command"), bit("command", "clear_output"))]


def test_what_an_index_error_says_is_taken_before_it_is_cleared(running: Firmware) -> None:
    """The firmware uses the information of the index error, that head 2 lost 40 counts, before it
    clears the error: the measured separation stays right, and the firmware does not use the turn in
    progress."""
    running.turn(turn())
    clean = running.turn(turn(seed=2))
    running.send("set release_sources 2")
    running.core.head2_slips(40)
    running.core.set("head2.flags", 0b0011)
    running.core.writes.clear()
    assert running.send("clear_output") == DRIVEN
    assert running.application.head2_zero == 40
    off_and_on = [word for offset, word in running.core.writes if offset == address("control")]
    captures = bit("control", "capture_enable")
    assert [bool(word & captures) for word in off_and_on] == [False, True]
    assert json.loads(running.step(2))["alarms"] == ["zero_lost"]
    after = running.turn(slipped(turn(seed=2), 40))
    assert after["separation_deg"] == clean["separation_deg"]


def test_a_held_core_is_only_cleared() -> None:
    """The command clears the faults of a core that the firmware holds after repeated faults; the
    firmware processes no turn and changes neither the capture nor the zeros."""
    core = ModelCore()
    core.see_index()
    firmware = Firmware(core)
    firmware.application.faults_in_a_row = 3
    firmware.library.application_begin(firmware.application)
    assert firmware.phase == "held"
    core.set("alarm", 0x0100)
    core.set("head1.flags", 0b0101)
    core.writes.clear()
    assert firmware.send("clear_output") == DRIVEN
    commands = bit("command", "clear_output") | bit("command", "clear_head1")
    assert core.writes == [(address("command"), commands)]
