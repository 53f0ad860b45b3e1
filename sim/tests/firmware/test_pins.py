"""Tests of trigger, sync, probe and compare: the commands of the console and the words that the
firmware writes to the core."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sim.tests.firmware.model_core import Firmware, ModelCore, address, bit
from sim.tests.firmware.test_application import controls, turn
from sim.tests.firmware.test_save import Board

TURN = 1 << 24
MODES = {"equal_times": 0, "equal_angles": 1, "sync_in": 2}


def capture_mode(core: ModelCore) -> int:
    return core.get("control") >> 3 & 3


def lines(firmware: Firmware, command: str) -> list[str]:
    return firmware.send(command).splitlines()


def test_presets_are_those_of_the_core(running: Firmware) -> None:
    assert running.core.get("pulse_widths") == 100 << 16 | 100
    assert running.core.get("pulse_inputs") == 1 << 8
    assert lines(running, "trigger") == ["trigger_width 100", "ok"]
    assert lines(running, "sync") == [
        "sync_capture 0",
        "sync_falling 0",
        "pulse_filter 1",
        "ok",
    ]


def test_widths_edges_and_filter_reach_the_core_at_once(running: Firmware) -> None:
    """The console changes the words without a re-arm, so that index and correction stay valid."""
    running.core.writes.clear()
    for line in (
        "trigger width 7",
        "compare width 300",
        "sync falling 1",
        "set probe_falling 1",
        "set pulse_filter 20",
    ):
        assert running.send(line) == "ok\r\n"
    assert running.core.get("pulse_widths") == 300 << 16 | 7
    assert running.core.get("pulse_inputs") == 20 << 8 | 0b11
    assert not [
        w for w in running.core.writes if w == (address("command"), bit("command", "rearm"))
    ]
    assert running.phase == "capture"


def test_samples_at_the_edges_of_sync_in(running: Firmware) -> None:
    assert running.send("sync capture 1") == "ok\r\n"
    assert capture_mode(running.core) == MODES["sync_in"]
    assert "samples sync_in" in lines(running, "status")
    # The firmware uses a turn sampled by sync_in like any other. A varying speed does not change
    # the capture mode.
    assert running.turn(turn())["result"] == "applied"
    assert controls(running.core)["compensate"]
    # The table turns, but sync_in has no edge; this is not a fault of the capture.
    for position in range(0, 40 * TURN, TURN // 2):
        running.core.stand_at(position % 2**31, 0)
        running.step()
    assert controls(running.core)["compensate"]
    assert "stuck_captures 0" in lines(running, "status")
    assert running.send("sync capture 0") == "ok\r\n"
    assert capture_mode(running.core) == MODES["equal_times"]


def test_a_dump_of_samples_from_outside_has_no_period(running: Firmware) -> None:
    running.send("sync capture 1")
    running.send("dump")
    running.core.hand_over(turn())
    assert " period_clocks=0 " in running.step(1).splitlines()[0]
    assert capture_mode(running.core) == MODES["sync_in"]


def test_the_probe_is_read_after_its_low_word(running: Firmware) -> None:
    core = running.core
    core.words[address("probe.time")] = 5
    core.words[address("probe.time") + 4] = 2
    core.set("probe.position", -7)
    core.set("probe.angle", 12345)
    core.set("probe.edges", 3)
    assert lines(running, "probe") == [
        "probe_falling 0",
        "pulse_filter 1",
        "edges 3",
        f"time_clocks {2 * 2**32 + 5}",
        "position_counts -7",
        "angle_counts 12345",
        "ok",
    ]


def test_events_are_printed_once_and_as_they_are_in_the_queue(running: Firmware) -> None:
    core = running.core
    assert running.send("probe events") == "error: the gateware is built without EVENTS\r\n"
    core.build_events()
    assert running.send("probe events") == "ok\r\n"
    values = [
        (65_535, 3, 2**63 - 1, -(2**31), TURN - 1),
        (0, 1, 0, 2**31 - 1, 0),
        *((number, 2, 77 * number, number - 5, 3 * number) for number in range(1, 99)),
    ]
    core.events.extend(values)
    wanted = ["event " + " ".join(map(str, value)) for value in values]
    assert lines(running, "probe events") == [*wanted[:64], "ok"]
    assert lines(running, "probe events") == [*wanted[64:], "ok"]
    assert running.send("probe events") == "ok\r\n"


def test_pulses_of_the_compare_are_recorded_on_request(running: Firmware) -> None:
    running.core.build_events()
    assert running.send("compare events 1") == "ok\r\n"
    assert running.core.get("events.recorded") == 0b11
    assert "compare_events 1" in lines(running, "compare")
    assert running.send("compare events 0") == "ok\r\n"
    assert running.core.get("events.recorded") == 0b01


@given(
    angle=st.integers(0, TURN - 1),
    interval=st.sampled_from([0, 1, 4096, 77_777, TURN - 1]),
    position=st.integers(-(2**31), 2**31 - 1),
    at_angle=st.integers(0, TURN - 1),
    upwards=st.booleans(),
)
@settings(max_examples=60, deadline=None)
def test_compare_begins_at_the_next_place_in_the_way_of_the_table(
    angle: int, interval: int, position: int, at_angle: int, upwards: bool
) -> None:
    firmware = Firmware(ModelCore())
    core = firmware.core
    core.stand_at((position - (1000 if upwards else -1000)) % 2**32, 0)
    firmware.library.application_start(firmware.application)
    core.see_index()
    firmware.step()
    core.stand_at(position % 2**32, at_angle)
    for line in (f"compare first {angle}", f"compare interval {interval}", "compare on 1"):
        assert firmware.send(line) == "ok\r\n"
    first, distance = core.armed[-1]
    assert distance == interval
    away = (first - position + 2**31) % 2**32 - 2**31
    margin, step = TURN // 1024 + 1, interval or TURN
    index = position - at_angle
    assert (position + away - (index + angle)) % step == 0
    assert margin <= (away if upwards else -away) < margin + step
    assert lines(firmware, "compare")[-2:] == ["armed yes", "ok"]
    assert firmware.send("compare on 0") == "ok\r\n"
    assert lines(firmware, "compare")[-2:] == ["armed no", "ok"]


def test_compare_waits_for_the_index_and_is_armed_anew_with_it() -> None:
    firmware = Firmware(ModelCore())
    firmware.library.application_start(firmware.application)
    firmware.send("compare on 1")
    assert firmware.core.armed == []
    firmware.core.see_index()
    firmware.step()
    assert len(firmware.core.armed) == 1
    firmware.send("rearm")
    assert lines(firmware, "compare")[-2] == "armed no"
    firmware.step()
    assert len(firmware.core.armed) == 2


def test_compare_follows_a_zero_that_moved(running: Firmware) -> None:
    running.send("compare on 1")
    running.core.moves_zero(-4)
    running.core.hand_over(turn())
    running.step(4)
    assert len(running.core.armed) == 2
    # With interval 0 there is only one pulse. After the table has passed its position, the firmware
    # does not arm the compare unit again.
    running.core.set("status", 0)
    running.core.moves_zero(-4)
    running.core.hand_over(turn())
    running.step(4)
    assert len(running.core.armed) == 2


def test_compare_begins_anew_with_a_zero_that_is_found_anew(running: Firmware) -> None:
    """The firmware arms the compare anew after it has found the zero again: head 1 loses counts, no
    index proves the loss for four turns, and the old places become invalid."""
    running.turn(turn())
    running.send("compare on 1")
    begin = running.core.get("snapshot.head1_position")
    for turns in (0.0, 4.1):
        position = int(begin + turns * TURN)
        running.application.position_at_bank = position
        running.core.set("snapshot.head1_position", position)
        running.core.head1_slips(-8)
        running.core.set("head1.flags", 0b11)
        running.step()
    assert running.phase == "wait_for_index"
    assert lines(running, "compare")[-2] == "armed no"
    running.core.see_index()
    running.step()
    assert len(running.core.armed) == 2


def test_a_fault_of_the_firmware_leaves_the_compare_at_work() -> None:
    core = ModelCore()
    core.set("status", bit("status", "compare_armed"))
    core.set("counts_per_rev_active", TURN)
    firmware = Firmware(core)
    firmware.application.parameters.compare_on = 1
    firmware.application.settings_origin = firmware.library.SETTINGS_KEPT
    firmware.library.application_begin(firmware.application)
    core.see_index()
    firmware.step()
    assert firmware.phase == "capture"
    assert core.armed == []
    assert lines(firmware, "compare")[-2] == "armed yes"


def test_they_are_saved() -> None:
    board = Board()
    for line in ("trigger width 9", "sync capture 1", "probe falling 1", "compare on 1"):
        assert board.firmware.send(line) == "ok\r\n"
    assert board.order("save").startswith("ok, record 1")
    board.power_on()
    assert board.core.get("pulse_widths") == 100 << 16 | 9
    assert board.core.get("pulse_inputs") == 1 << 8 | 0b10
    assert capture_mode(board.core) == MODES["sync_in"]
    assert len(board.core.armed) == 1


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("compare on", "error: expected a value after on"),
        ("compare on 2", "error: compare_on takes 0.00 to 1"),
        ("compare first 16777216", "error: compare_first takes 0.00 to 16777215"),
        ("trigger width 0", "error: trigger_width takes 1.00 to 65535"),
        ("trigger colour 1", "error: no parameter trigger_colour"),
        ("probe " + "x" * 70 + " 1", "error: no parameter probe_" + "x" * 25),
        ("sync capture yes", "error: not a decimal number: yes"),
    ],
)
def test_what_they_do_not_take(running: Firmware, line: str, answer: str) -> None:
    assert running.send(line) == answer + "\r\n"


def test_without_a_core_they_are_shown_and_kept() -> None:
    idle = Firmware(ModelCore())
    assert lines(idle, "probe") == ["probe_falling 0", "pulse_filter 1", "ok"]
    assert idle.send("trigger width 5") == "ok\r\n"
    assert idle.core.writes == []
