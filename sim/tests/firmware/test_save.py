"""Tests that parameters and coefficients in the flash survive a loss of power at any byte of a
write."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sim.tests.calibration.synthetic import COUNTS, Disc
from sim.tests.firmware.flash_model import Chip, Controller
from sim.tests.firmware.library import firmware as c_library
from sim.tests.firmware.model_core import Firmware, ModelCore
from sim.tests.firmware.test_application import active_coefficients, controls
from sim.tests.firmware.test_load import (
    DISC,
    HIGH,
    LEFT_ARCSEC,
    SUBDIVISION,
    file_of,
    left,
    load,
    send,
    state,
    turn,
)
from sim.tests.firmware.test_load_followed import CONDITIONS, last_lane, with_direction
from sim.tests.firmware.test_load_followed import modulators as with_modulators
from sim.tests.firmware.test_load_real import ORDERS as REAL_ORDERS
from sim.tests.firmware.test_load_real import (
    REAL_LANES,
    lane_words,
    turn_step_at,
    with_real_orders,
)
from sim.tests.firmware.test_load_real import built as built_with_real_orders
from sim.tests.firmware.test_load_real import status as real_order_status

from arctrue.device.load import load_frames, phase_commands
from arctrue.gateware.lane_words import turn_step
from arctrue.gateware.register_access import coefficient_words

REGION = range(0xF0_0000, 0x100_0000)
"""Region of the records, one record per sector: 4 sectors of 256 KB or 16 of 64 KB."""
STEPS_MOST = 1_000
"""Largest number of steps of 10 ms. An erase takes 0.5 s; the firmware gives up an erase after 8
s."""


class Board:
    """A board whose flash chip keeps its content without power; ``power_on`` starts the firmware on
    a new core, as main() does."""

    def __init__(self, chip: Chip | None = None) -> None:
        self.chip = chip or Chip()
        self.power_on()

    def new_core(self) -> ModelCore:
        return ModelCore()

    def power_on(self, after_fault: bool = False) -> None:
        ffi, library = c_library()
        self.core = self.new_core()
        self.controller = Controller(self.chip)
        self.chip.busy_until_us = 0
        self.firmware = Firmware(self.core)
        self.flash = ffi.new("struct flash *")
        library.flash_prepare(self.flash, self.controller.access)
        self.save = ffi.new("struct save *")
        access = ffi.new("struct flash_access *", library.flash_access_to(self.flash))
        library.save_prepare(self.save, access, REGION.start, len(REGION))
        application = self.firmware.application
        library.application_use_flash(application, self.save)
        library.application_recover(application, after_fault)
        library.application_begin(application)
        self.core.see_index()
        self.firmware.step()

    def order(self, line: str) -> str:
        """Send a line and return the answer; ``save`` answers after it has read the record back."""
        said = self.firmware.send(line)
        for _ in range(STEPS_MOST):
            if said:
                return said
            self.controller.now_us += 10_000
            said = self.firmware.step()
        raise AssertionError("no answer")

    def status(self, name: str) -> list[str]:
        return self.firmware.status(name)

    def work(self, turns: range, disc: Disc = DISC) -> None:
        for seed in turns:
            self.firmware.turn(turn(seed, disc=disc))


@pytest.fixture
def working() -> Board:
    """Return a calibrated board with a loaded correction of the subdivision error."""
    board = Board()
    board.firmware.send("set orders 8")
    board.work(range(1, 5))
    load(board.firmware, file_of(SUBDIVISION))
    board.work(range(5, 7))
    assert left(board.firmware) < LEFT_ARCSEC
    return board


def test_power_off_and_on_needs_one_turn_and_no_word(working: Board) -> None:
    working.firmware.send("set keep 0.5")
    ordered = working.firmware.parameters()
    assert working.order("save").startswith("ok, record 1: parameters and ")
    bank = active_coefficients(working.core)
    working.power_on()
    assert working.firmware.parameters() == ordered
    assert working.status("settings") == ["saved"]
    assert working.status("saved") == ["waiting"]
    assert not controls(working.core)["compensate"], "no turn has confirmed them yet"
    telemetry = working.firmware.turn(turn(seed=9))
    assert (telemetry["result"], telemetry["alarms"]) == ("applied", [])
    assert working.status("saved") == ["confirmed"]
    assert controls(working.core)["compensate"]
    assert left(working.firmware) < LEFT_ARCSEC
    again = active_coefficients(working.core)
    order = np.argsort(again.phase_steps[again.amplitudes != 0])
    before = np.argsort(bank.phase_steps[bank.amplitudes != 0])
    assert (
        (again.amplitudes[again.amplitudes != 0][order]).tolist()
        == (bank.amplitudes[bank.amplitudes != 0][before]).tolist()
    )
    assert state(working.firmware) == "load active"
    # The calibration continues with the other orders and leaves the loaded order unchanged.
    moved = Disc({**DISC.orders, 1: (155.0, 0.4)})
    working.work(range(10, 34), disc=moved)
    assert left(working.firmware, moved) < 2 * LEFT_ARCSEC


def test_lanes_that_follow_a_condition_outlive_the_power() -> None:
    """The first turn that confirms the other lanes also writes back the words of the lanes that
    follow direction or speed, and the settings (width, dead zone, nominal speed) of this condition.
    """
    board = Board()
    with_modulators(board.firmware)
    board.firmware.send("set orders 8")
    board.work(range(1, 5))
    wanted = with_direction(SUBDIVISION)
    assert set(send(board.firmware, load_frames(wanted, force=True))) == {"ok"}
    board.work(range(5, 7))
    words = coefficient_words(wanted)[-4:]
    assert last_lane(board.core.active) == words
    assert board.order("save").startswith("ok, record 1: parameters and ")
    board.power_on()
    with_modulators(board.firmware)
    assert board.core.active == {}
    telemetry = board.firmware.turn(turn(seed=9))
    assert (telemetry["result"], telemetry["alarms"]) == ("applied", [])
    assert board.status("saved") == ["confirmed"]
    assert last_lane(board.core.active) == words
    assert board.core.get("conditions.width") == CONDITIONS.width
    assert board.core.get("conditions.dead_zone") == CONDITIONS.dead_zone_counts
    assert board.core.get("conditions.nominal_speed") > 0
    # The next turn of the calibration and the next save keep the words.
    board.work(range(10, 12))
    assert last_lane(board.core.active) == words
    assert board.order("save").startswith("ok, record 2: parameters and ")


def test_a_core_without_modulators_does_not_take_the_saved_lanes() -> None:
    board = Board()
    with_modulators(board.firmware)
    board.firmware.send("set orders 8")
    board.work(range(1, 5))
    send(board.firmware, load_frames(with_direction(SUBDIVISION), force=True))
    board.work(range(5, 7))
    assert board.order("save").startswith("ok")
    board.power_on()
    telemetry = board.firmware.turn(turn(seed=9))
    assert "not_confirmed" in telemetry["alarms"]
    assert board.core.active == {} or last_lane(board.core.active) == [0, 0, 0, 0]


def test_without_the_record_one_turn_does_not_correct_what_was_loaded(working: Board) -> None:
    """After a power cycle without a record, one turn does not correct the subdivision error, which
    only the loaded coefficients corrected; this test is the opposite of
    test_power_off_and_on_needs_one_turn_and_no_word."""
    working.power_on()
    working.firmware.turn(turn(seed=9))
    assert left(working.firmware) > 0.4


def test_another_table_does_not_get_them(working: Board) -> None:
    """The firmware does not give the saved coefficients to another table: the operator has turned
    the disc on its hub, so that order 1 has another phase."""
    working.order("save")
    working.power_on()
    other = Disc({n: (a, p + 2.0) for n, (a, p) in DISC.orders.items()})
    telemetry = working.firmware.turn(turn(seed=9, disc=other))
    assert telemetry["alarms"] == ["not_confirmed"]
    assert working.status("saved") == ["not_confirmed"]
    assert any("contradicts the saved" in advice for advice in working.status("advice"))
    assert left(working.firmware, other) < 0.7, "the firmware calibrated the other table"
    bank = active_coefficients(working.core)
    assert bank.amplitudes[bank.phase_steps == HIGH * 2**48 // COUNTS].size == 0
    # The operator puts the disc back into its old place.
    working.firmware.send("rearm")
    working.core.see_index()
    working.firmware.step()
    working.work(range(10, 11))
    assert working.status("saved") == ["confirmed"]
    assert left(working.firmware) < LEFT_ARCSEC


def test_a_turn_that_cannot_be_used_decides_nothing(working: Board) -> None:
    working.order("save")
    working.power_on()
    bad = turn(seed=5)
    bad[0, 500:] += 50_000
    assert working.firmware.turn(bad)["reason"] == "jump"
    assert working.status("saved") == ["waiting"]
    assert not controls(working.core)["compensate"]


def test_a_set_that_is_loaded_meanwhile_comes_after_it(working: Board) -> None:
    working.order("save")
    working.power_on()
    load(working.firmware, file_of({HIGH: (0.45, 1.3)}))
    working.work(range(9, 10))
    assert (working.status("saved"), state(working.firmware)) == (["confirmed"], "load waiting")
    working.work(range(10, 11))
    assert state(working.firmware) == "load active"
    assert 0.04 < left(working.firmware) < 0.04 + 2 * LEFT_ARCSEC


def test_bypass_and_freeze_are_saved_too(working: Board) -> None:
    for line in ("bypass on", "freeze on", "save"):
        assert working.order(line).startswith("ok")
    working.power_on()
    working.work(range(9, 10))
    assert working.status("saved") == ["confirmed"]
    assert not controls(working.core)["compensate"]
    assert working.status("compensation") == ["bypassed"]
    assert working.status("coefficients") == ["frozen"]


def test_a_save_before_the_first_turn_keeps_the_coefficients_that_wait(working: Board) -> None:
    """A save before the first turn keeps all earlier content: after power-on the operator sets and
    saves a parameter before any turn was judged."""
    said = working.order("save")
    working.power_on()
    working.firmware.send("set keep 0.5")
    assert working.order("save") == said.replace("record 1", "record 2")
    assert working.status("saved") == ["waiting"]
    working.power_on()
    assert working.firmware.parameters()["keep"] == "0.500000000"
    working.work(range(9, 10))
    assert working.status("saved") == ["confirmed"]
    assert left(working.firmware) < LEFT_ARCSEC


def re_armed(board: Board, line: str) -> None:
    board.firmware.send(line)
    board.core.see_index()
    board.firmware.step()


@pytest.mark.parametrize("line", ["set ramp_arcsec_s 100", "rearm"])
@pytest.mark.parametrize("saved_before", [False, True])
def test_a_save_after_a_re_arm_keeps_the_coefficients(
    working: Board, line: str, saved_before: bool
) -> None:
    """A save after a re-arm keeps the former coefficients and the loaded file, although no
    coefficients are active and no turn has come."""
    if saved_before:
        working.order("save")
    bank = active_coefficients(working.core)
    orders = int(np.count_nonzero(bank.amplitudes))
    re_armed(working, line)
    assert not controls(working.core)["compensate"]
    said = working.order("save")
    assert said.endswith(f": parameters and {orders} orders\r\n"), said
    working.power_on()
    working.work(range(9, 10))
    assert working.status("saved") == ["confirmed"]
    assert left(working.firmware) < LEFT_ARCSEC
    assert f"loaded_order {HIGH}\r\n" in working.firmware.send("load status")


def test_a_save_of_nothing_keeps_what_no_turn_has_confirmed(working: Board) -> None:
    """A save keeps the record's coefficients if no turn has confirmed them. A frozen firmware saves
    the record; after power-on the disc differs, so that no coefficients become active. The next
    save must contain the coefficients again."""
    working.firmware.send("freeze on")
    said = working.order("save")
    working.power_on()
    other = Disc({n: (a, p + 2.0) for n, (a, p) in DISC.orders.items()})
    working.work(range(9, 10), disc=other)
    assert working.status("saved") == ["not_confirmed"]
    assert working.order("save") == said.replace("record 1", "record 2")
    working.power_on()
    working.work(range(10, 11))
    assert working.status("saved") == ["confirmed"]


def test_a_counts_per_rev_that_is_set_back_has_lost_nothing(working: Board) -> None:
    said = working.order("save")
    re_armed(working, "set counts_per_rev 65536")
    re_armed(working, f"set counts_per_rev {COUNTS}")
    assert working.order("save") == said.replace("record 1", "record 2")


def test_fewer_orders_than_the_record_has_are_not_written(working: Board) -> None:
    """`save_begin` refuses a call with fewer orders than the record has."""
    ffi, library = c_library()
    working.order("save")
    kept = working.save.kept_lanes
    assert kept == np.count_nonzero(active_coefficients(working.core).amplitudes)
    programmed = len(working.chip.programmed)
    ffi.addressof(working.save.content, "own").lanes = 0
    answer = library.save_begin(working.save, kept)
    assert ffi.string(library.save_answer_name(answer)) == b"fewer_orders"
    assert working.save.state == library.SAVE_IDLE
    assert len(working.chip.programmed) == programmed
    assert len(working.firmware.send("help fewer_orders").splitlines()[0].split()) > 5


def calibrate_fewer(working: Board) -> None:
    """Save, and let the board calibrate another disc that needs fewer orders, until a re-arm."""
    working.order("save")
    working.power_on()
    other = Disc({1: (150.0, 2.4)})
    working.work(range(9, 11), disc=other)
    assert working.status("saved") == ["not_confirmed"]
    re_armed(working, "rearm")
    assert working.status("saved") == ["waiting"]


def test_a_save_that_would_drop_orders_leaves_the_coefficients_that_wait(working: Board) -> None:
    """The refused save has not replaced the record's coefficients in memory: the disc is back in
    its old place, and one turn confirms them."""
    calibrate_fewer(working)
    assert working.order("save") == "error: save fewer_orders\r\n"
    assert working.status("saved") == ["waiting"]
    working.work(range(12, 13))
    assert working.status("saved") == ["confirmed"]
    assert left(working.firmware) < LEFT_ARCSEC


def test_a_save_into_a_silent_flash_leaves_the_coefficients_that_wait(working: Board) -> None:
    """The failed save keeps the waiting coefficients. A save that succeeds with another number of
    counts per turn drops them."""
    working.order("save")
    working.power_on()
    re_armed(working, "set counts_per_rev 65536")
    working.chip.fault = "silent"
    assert working.order("save") == "error: save flash_unknown\r\n"
    working.chip.fault = ""
    re_armed(working, f"set counts_per_rev {COUNTS}")
    working.work(range(9, 10))
    assert working.status("saved") == ["confirmed"]
    assert left(working.firmware) < LEFT_ARCSEC


def test_coefficients_that_wait_for_another_table_are_not_kept(working: Board) -> None:
    working.order("save")
    working.power_on()
    working.firmware.send("set counts_per_rev 65536")
    assert working.order("save") == "ok, record 2: parameters and 0 orders\r\n"
    working.power_on()
    assert working.status("saved_record") == ["2"]


def test_after_a_fault_that_lost_the_settings_the_saved_ones_and_bypass(working: Board) -> None:
    working.firmware.send("set separation_deg 33.5")
    working.order("save")
    working.power_on(after_fault=True)
    assert working.status("settings") == ["lost"]
    assert working.firmware.parameters()["separation_deg"] == "33.500000000"
    assert working.status("compensation") == ["bypassed"]


def test_forget_then_save_forgets_in_the_flash_too(working: Board) -> None:
    working.order("save")
    working.firmware.send("forget")
    assert working.order("save") == "ok, record 2: parameters and 0 orders\r\n"
    working.power_on()
    assert (working.status("saved"), working.status("saved_record")) == (["none"], ["2"])


def places_of(chip: Chip) -> list[int]:
    return list(REGION[:: chip.sector])


@pytest.mark.parametrize("kind", ["s25fl128s_256k", "n25q128"])
def test_records_are_written_in_turn_and_nothing_else(kind: str) -> None:
    board = Board(Chip(kind))
    places = places_of(board.chip)
    for number in range(1, len(places) + 3):
        board.order("save")
        assert board.status("saved_record") == [str(number)]
    assert board.chip.erased == [*places, *places[:2]]
    assert_only_records_are_written(board.chip)


def assert_only_records_are_written(chip: Chip) -> None:
    """Assert that the firmware has written neither the boot image nor the bitstream."""
    for address in chip.erased:
        assert address in REGION
    for address, data in chip.programmed:
        assert address in REGION
        assert address % chip.sector + len(data) <= 4 << 10


def saved_times(number: int, kind: str = "s25fl128s_256k") -> Board:
    """Save ``number`` records; in record n the parameter ``keep`` is n hundredths."""
    board = Board(Chip(kind))
    for record in range(1, number + 1):
        board.firmware.send(f"set keep 0.{record:02}")
        assert board.order("save").startswith(f"ok, record {record}: ")
    return board


@pytest.mark.parametrize("silence", ["all", "after_its_id"])
def test_a_start_at_which_the_flash_is_silent_costs_no_record(silence: str) -> None:
    """The firmware keeps its records if the flash is silent at the start. An earlier firmware would
    have started again with record number 1 in the sector of the latest record."""
    board = saved_times(5)
    board.chip.fault = "silent" if silence == "all" else "silent_after_id"
    board.power_on()
    assert board.status("saved_record") == ["unread"]
    assert any("did not answer" in advice for advice in board.status("advice"))
    assert board.firmware.parameters()["keep"] == "0.800000000"
    board.chip.fault = "silent"
    erased = len(board.chip.erased)
    assert board.order("save") == "error: save flash_unknown\r\n"
    board.chip.fault = ""
    assert board.order("save") == "error: save not_read_at_start\r\n"
    assert "not in use" in board.firmware.send("help not_read_at_start")
    assert len(board.chip.erased) == erased, "nothing is written before the save is repeated"
    assert board.status("saved_record") == ["5"]
    board.power_on()
    assert board.firmware.parameters()["keep"] == "0.050000000", "the saved parameters apply again"


def test_the_operator_may_replace_what_was_not_read_at_the_start() -> None:
    board = saved_times(6)
    board.chip.fault = "silent"
    board.power_on()
    board.chip.fault = ""
    board.firmware.send("set keep 0.9")
    assert board.order("save").startswith("error: save not_read_at_start")
    assert board.order("save").startswith("ok, record 7: ")
    board.power_on()
    assert board.status("saved_record") == ["7"]
    assert board.firmware.parameters()["keep"] == "0.900000000"


def test_an_empty_flash_that_was_silent_at_the_start_is_written_at_once() -> None:
    board = Board(Chip())
    board.chip.fault = "silent"
    board.power_on()
    board.chip.fault = ""
    assert board.order("save").startswith("ok, record 1: ")


@pytest.mark.parametrize("wear", ["erase", "program"])
@pytest.mark.parametrize("kind", ["s25fl128s_256k", "n25q128"])
def test_a_worn_sector_is_skipped(kind: str, wear: str) -> None:
    """The firmware skips two neighbouring worn sectors; until the next power-off it tries each of
    them once."""
    board = saved_times(1, kind)
    places = places_of(board.chip)
    board.chip.worn = {places[1]: wear, places[2]: wear}
    for number in range(2, len(places) + 4):
        board.firmware.send(f"set keep 0.{number:02}")
        answer = board.order("save")
        assert answer.startswith("ok, record "), answer
        assert answer.endswith("; worn sectors: 2\r\n")
        assert board.status("saved_worn_sectors") == ["2"]
    assert [board.chip.erased.count(place) for place in places[1:3]] == [1, 1]
    (kept,) = board.status("saved_record")
    board.power_on()
    assert board.status("saved_record") == [kept]
    assert board.firmware.parameters()["keep"] == f"0.{number:02}0000000"
    assert_only_records_are_written(board.chip)


def test_the_last_good_sector_keeps_its_record() -> None:
    """The last good sector keeps its record: a save fails, because all other sectors are worn."""
    board = saved_times(2)
    good = places_of(board.chip)[1]
    board.chip.worn = {place: "program" for place in places_of(board.chip) if place != good}
    for _ in range(3):
        assert board.order("save") == "error: save flash_not_read_back\r\n"
        assert board.status("saved_record") == ["2"]
    board.power_on()
    assert board.firmware.parameters()["keep"] == "0.020000000"
    assert board.chip.erased.count(good) == 1


def test_a_record_that_was_not_confirmed_is_not_preferred() -> None:
    """The firmware does not prefer a complete record that it failed to read back; the next save has
    a higher number."""
    board = saved_times(1)
    board.firmware.send("set keep 0.5")
    board.firmware.send("save")
    for _ in range(STEPS_MOST):
        if board.save.state == c_library()[1].SAVE_READING_BACK:
            break
        board.controller.now_us += 10_000
        board.firmware.step()
    board.controller.fault = "silent"
    board.controller.now_us += 100_000
    assert board.firmware.step() == "error: save flash_stuck\r\n"
    board.controller.fault = ""
    board.firmware.send("set keep 0.6")
    assert board.order("save").startswith("ok, record 3: ")
    board.power_on()
    assert board.firmware.parameters()["keep"] == "0.600000000"


@pytest.mark.parametrize(
    ("fault", "reason"),
    [
        ("silent", "flash_unknown"),
        ("protected", "flash_not_erased"),
        ("bad_bit", "flash_not_read_back"),
        ("stuck", "flash_stuck"),
    ],
)
def test_a_flash_that_does_not_take_it(working: Board, fault: str, reason: str) -> None:
    working.order("save")
    working.order("save")
    for place in places_of(working.chip)[2:]:
        working.chip.content[place : place + 4096] = bytes(4096)
    working.chip.fault = fault
    assert working.order("save") == f"error: save {reason}\r\n"
    assert len(working.firmware.send(f"help {reason}").splitlines()[0].split()) > 5
    working.chip.fault = ""
    working.power_on()
    assert working.status("saved_record") == ["2"], "the former record remains"


def test_one_at_a_time(working: Board) -> None:
    assert working.firmware.send("save") == ""
    assert working.firmware.send("save") == "error: save under_way\r\n"


def test_the_turns_go_on_while_the_flash_is_erased(working: Board) -> None:
    working.firmware.send("save")
    assert working.firmware.turn(turn(seed=9))["result"] in ("applied", "kept")


class Memory:
    """The region of the records as plain bytes, for tests that read many contents."""

    def __init__(self, content: bytes | memoryview, sector: int = 4096) -> None:
        ffi, library = c_library()
        self.content = content
        self._calls = (
            ffi.callback("flash_access_open", lambda _: sector),
            ffi.callback("flash_access_read", self.read),
        )
        access = ffi.new("struct flash_access *", [*self._calls, ffi.NULL, ffi.NULL, ffi.NULL])
        self.save = ffi.new("struct save *")
        library.save_prepare(self.save, access, 0, len(content))

    def read(self, _: Any, address: int, words: Any, number: int) -> bool:
        data = bytes(self.content[address : address + 4 * number]).ljust(4 * number, b"\xff")
        c_library()[0].buffer(words, 4 * number)[:] = data
        return True

    def found(self) -> int | None:
        """Return the sequence number of the record that the firmware reads at power-on."""
        if not c_library()[1].save_find(self.save):
            return None
        return int(self.save.sequence)


def record_of(chip: Chip, place: int) -> bytes:
    """Return the record in a sector; its length is that of the last write that began at the
    sector's start, plus the pages that followed."""
    length = 0
    for address, data in chip.programmed:
        if place <= address < place + chip.sector:
            first = address == place
            length = len(data) if first else address + len(data) - place
    return bytes(chip.content[place : place + length])


def records(working: Board) -> tuple[bytes, bytes]:
    """Return two consecutive records in the form in which the flash stores them."""
    working.order("save")
    working.firmware.send("set keep 0.25")
    working.work(range(20, 22))
    working.order("save")
    first, second = (record_of(working.chip, place) for place in places_of(working.chip)[:2])
    return first, second


def flash_of(first: bytes, second: bytes) -> Memory:
    return Memory(first.ljust(4096, b"\xff") + second.ljust(4096, b"\xff"))


def test_power_lost_at_any_byte_of_the_write(working: Board) -> None:
    """The firmware finds a complete record if power is lost at any moment while record 3 replaces
    record 1: the sector is erased in part or in full, or written up to any byte."""
    first, second = records(working)
    working.order("save")
    third = record_of(working.chip, places_of(working.chip)[2])
    length = len(third)
    first = first.ljust(length, b"\xff")
    draw = np.random.default_rng(1)
    for cut in range(length):
        # In the byte that is being written, each bit that should become 0 may still be 1.
        torn = bytes([third[cut] | int(draw.integers(256))])
        found = flash_of(third[:cut] + (torn if torn != third[cut : cut + 1] else b""), second)
        assert found.found() == 2, cut
        erased = np.frombuffer(first, dtype=np.uint8) | draw.integers(
            0, 256, length, dtype=np.uint8
        )
        assert flash_of(first[:cut] + erased[cut:].tobytes(), second).found() == 2, cut
    assert flash_of(third, second).found() == 3
    assert flash_of(first, second).found() == 2


def test_the_first_save_that_is_cut_off_is_no_record(working: Board) -> None:
    first, _ = records(working)
    for cut in range(0, len(first) - 1, 7):
        assert flash_of(first[:cut], b"").found() is None


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_no_changed_bit_is_taken(data: Any) -> None:
    first = record_of_presets()
    memory = bytearray(first)
    for place in data.draw(st.lists(st.integers(0, 8 * len(first) - 1), min_size=1, max_size=3)):
        memory[place // 8] ^= 1 << place % 8
    if bytes(memory) != first:
        assert flash_of(bytes(memory), b"").found() is None


def record_of_presets(**parameters: float) -> bytes:
    ffi, library = c_library()
    saved = ffi.new("struct saved *")
    library.parameters_preset(ffi.addressof(saved.settings, "parameters"))
    for name, value in parameters.items():
        setattr(saved.settings.parameters, name, value)
    saved.own.counts_per_rev = saved.loaded.counts_per_rev = int(
        saved.settings.parameters.counts_per_rev
    )
    words = ffi.new("uint32_t[]", library.SAVED_WORDS_MOST)
    number = library.saved_write(saved, 5, words)
    return bytes(ffi.buffer(words, 4 * number))


def with_words(record: bytes, **words: int) -> bytes:
    """Return the record with changed words and a correct checksum, as a firmware of another version
    would write it."""
    places = {"magic": 0, "version": 1, "sequence": 2, "length": 3, "switches": 4, "parameters": 5}
    changed = bytearray(record[:-4])
    for name, word in words.items():
        changed[4 * places[name] : 4 * places[name] + 4] = word.to_bytes(4, "little")
    return bytes(changed) + zlib.crc32(changed).to_bytes(4, "little")


@pytest.mark.parametrize(
    ("record", "answer"),
    [
        (lambda r: r, "read"),
        (lambda _: b"", "none"),
        (lambda r: with_words(r, magic=0x12345678), "damaged"),
        (lambda r: with_words(r, length=0x7FFF_FFFF), "damaged"),
        (lambda r: with_words(r, version=2), "other_version"),
        (lambda r: with_words(r, switches=8), "out_of_range"),
        (lambda r: with_words(r, parameters=65), "out_of_range"),
        (lambda r: with_words(r, parameters=3), "out_of_range"),
        (lambda _: record_of_presets(keep=float("nan")), "out_of_range"),
        (lambda _: record_of_presets(orders=3.5), "out_of_range"),
    ],
)
def test_what_a_record_can_be(record: Any, answer: str) -> None:
    ffi, library = c_library()
    memory = flash_of(record(record_of_presets()), b"")
    assert memory.found() == (5 if answer == "read" else None)
    assert ffi.string(library.saved_answer_name(memory.save.found)).decode() == answer


def test_the_sequence_number_wraps() -> None:
    old = with_words(record_of_presets(), sequence=0xFFFF_FFFF)
    new = with_words(record_of_presets(), sequence=0)
    assert flash_of(old, new).found() == 0
    assert flash_of(new, old).found() == 0


def test_a_parameter_that_the_record_does_not_have_is_preset() -> None:
    """The firmware presets a parameter that the record of an older firmware lacks, and ignores a
    parameter that no longer exists."""
    record = record_of_presets(keep=0.25, noise_limit=7.0)
    words = np.frombuffer(record, dtype="<u4").copy()
    ffi, library = c_library()
    names = [
        ffi.string(library.parameters_description(i).name).decode()
        for i in range(library.parameters_number())
    ]
    words[6 + 3 * names.index("keep")] ^= 1
    memory = flash_of(with_words(words.tobytes()), b"")
    assert memory.found() == 5
    found = memory.save.content.settings.parameters
    assert (found.keep, found.noise_limit) == (0.8, 7.0)


def test_lanes_of_real_orders_outlive_the_power_and_have_no_phase() -> None:
    """Orders and amplitudes of lanes of real orders (orders that are not integers) return with the
    first turn; the lanes stay off until the operator gives a phase.

    A phase refers to the core's count of turns, which starts at 0 after power-on.
    """
    board = Board()
    built_with_real_orders(board.firmware)
    board.firmware.send("set orders 8")
    board.work(range(1, 5))
    wanted = with_real_orders(SUBDIVISION)
    assert set(send(board.firmware, load_frames(wanted, unseen=True))) == {"ok"}
    board.work(range(5, 8))
    for line in phase_commands(wanted, 0):
        assert board.firmware.send(line).strip() == "ok"
    board.firmware.step(5)
    words = {lane: lane_words(board.core.active, lane) for lane in REAL_LANES}
    assert all(amplitude != 0 for *_, amplitude in words.values())
    assert board.order("save").startswith("ok, record 1: parameters and ")
    board.power_on()
    built_with_real_orders(board.firmware)
    telemetry = board.firmware.turn(turn(seed=9))
    assert (telemetry["result"], telemetry["alarms"]) == ("applied", [])
    assert board.status("saved") == ["confirmed"]
    assert real_order_status(board.firmware)[:2] == [
        "real_order 0.500000000 phase_unknown",
        "real_order 71.400000000 phase_unknown",
    ]
    for lane, order in zip(REAL_LANES, REAL_ORDERS, strict=True):
        assert lane_words(board.core.active, lane)[3] == 0
        assert turn_step_at(board.firmware, lane) == turn_step(order)
    for line in phase_commands(wanted, 0):
        assert board.firmware.send(line).strip() == "ok"
    board.firmware.step(5)
    assert {lane: lane_words(board.core.active, lane) for lane in REAL_LANES} == words
    assert board.order("save").startswith("ok, record 2: parameters and ")


def test_a_core_without_real_orders_does_not_take_the_saved_lanes() -> None:
    board = Board()
    built_with_real_orders(board.firmware)
    board.firmware.send("set orders 8")
    board.work(range(1, 5))
    send(board.firmware, load_frames(with_real_orders(SUBDIVISION), unseen=True))
    board.work(range(5, 8))
    assert board.order("save").startswith("ok")
    board.power_on()
    assert "not_confirmed" in board.firmware.turn(turn(seed=9))["alarms"]
