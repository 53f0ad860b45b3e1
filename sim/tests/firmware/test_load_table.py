"""Tests that the firmware loads a local table from the console completely or not at all, and that
captured turns confirm or refute the table."""

from __future__ import annotations

import dataclasses
import struct
import zlib
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.calibration.synthetic import ARCSEC, COUNTS, Disc
from sim.tests.firmware import test_prepared_sets as prepared
from sim.tests.firmware.model_core import Firmware, address
from sim.tests.firmware.test_application import ARCSEC_PER_COUNT, active_coefficients
from sim.tests.firmware.test_load import DISC, file_of, running, send, state, turn
from sim.tests.firmware.test_save import REGION, Board

from arctrue.calibration.acceptance import of_limits
from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import POINTS, LocalTable
from arctrue.gateware.local_table import LocalTable as Bank
from arctrue.gateware.local_table import local_table
from arctrue.generated.registers import LOCAL_POINTS_ADDRESS

__all__ = ["running"]

Float = NDArray[np.float64]
HEIGHT_ARCSEC, PLACE_RAD, SIGMA_RAD = 20.0, np.radians(84.0), np.radians(0.85)
WIDTH_EXPONENT, FRACTION = 3, 8
LOCAL_TABLE = 1 << 7
READINGS = np.arange(0, COUNTS, COUNTS // 65_536 - 1)


def bump(theta: Float) -> Float:
    """Return the error that the scratch adds at the angle ``theta``, in arcseconds."""
    away = np.angle(np.exp(1j * (theta - PLACE_RAD)))
    return np.asarray(HEIGHT_ARCSEC * np.exp(-0.5 * (away / SIGMA_RAD) ** 2))


@dataclass(frozen=True)
class Scratched(Disc):
    """A disc with a scratch that passes every head in each turn."""

    def error_rad(self, theta: Float) -> Float:
        return Disc.error_rad(self, theta) + bump(theta) * ARCSEC


SCRATCHED = Scratched(DISC.orders)


@dataclass(frozen=True)
class Opposite(Disc):
    """A disc whose scratch has the opposite sign."""

    def error_rad(self, theta: Float) -> Float:
        return Disc.error_rad(self, theta) - bump(theta) * ARCSEC


OPPOSITE = Opposite(DISC.orders)


def table_file(size: float = 1.0, shift_counts: int = 0) -> Coefficients:
    """Return coefficients with only a local table: ``size`` times the scratch, shifted by this
    number of counts."""
    width = COUNTS >> WIDTH_EXPONENT
    start = int(PLACE_RAD / (2.0 * np.pi) * COUNTS) - width // 2
    theta = (start + np.arange(POINTS) * width / POINTS) * (2.0 * np.pi / COUNTS)
    words = np.rint(size * bump(theta) / ARCSEC_PER_COUNT * 2**FRACTION).astype(np.int64)
    held = LocalTable(
        tuple(words.tolist()), ((start + shift_counts) % COUNTS,), WIDTH_EXPONENT, FRACTION
    )
    return dataclasses.replace(file_of({}), extension=Extension(local_table=held))


def bank_of(coefficients: Coefficients) -> Bank:
    assert coefficients.extension is not None
    assert coefficients.extension.local_table is not None
    return Bank.of_file(coefficients.extension.local_table, COUNTS)


def built(running: Firmware) -> None:
    running.core.set("version", 0x000800)
    running.core.set("capability", LOCAL_TABLE | 2)


def loaded(running: Firmware, coefficients: Coefficients, turns: int = 3) -> str:
    """Load the file, run turns of the scratched disc, and return the state of the load."""
    built(running)
    assert set(send(running, load_frames(coefficients))) == {"ok"}
    assert state(running) == "load waiting"
    for seed in range(5, 5 + turns):
        running.turn(turn(seed, disc=SCRATCHED))
    return state(running)


def place_words(running: Firmware) -> list[int]:
    first = address("local_place.choice")
    return [running.core.words.get(first + 4 * word, 0) for word in range(7)]


def test_a_scratch_is_taken_away(running: Firmware) -> None:
    wanted = table_file()
    assert loaded(running, wanted) == "load active"
    bank = bank_of(wanted)
    assert place_words(running) == bank.place_words()
    points = [running.core.words[LOCAL_POINTS_ADDRESS + 4 * number] for number in range(POINTS)]
    assert points == [int(point) & 0xFFFF_FFFF for point in bank.points]
    assert "loaded_table_crc" in running.send("load status")
    # The calibration continues: its lanes and the table correct together.
    angle = READINGS * (2.0 * np.pi / COUNTS)
    wrong = np.rad2deg(angle - SCRATCHED.true_angle(angle)) * 3600.0
    lanes = active_coefficients(running.core).error_counts(READINGS) * ARCSEC_PER_COUNT
    corrected = lanes + local_table(READINGS, bank) * 2.0**-22 * ARCSEC_PER_COUNT
    # The lanes do not correct the subdivision error of test_load, and they fit a part of the
    # scratch.
    assert np.abs(wrong - corrected).max() < HEIGHT_ARCSEC / 10.0
    assert np.abs(wrong - lanes).max() > 0.9 * HEIGHT_ARCSEC


@pytest.mark.parametrize(
    ("size", "shift"), [(-1.0, 0), (1.0, COUNTS // 12)], ids=["negative", "elsewhere"]
)
def test_a_wrong_table_is_refused(running: Firmware, size: float, shift: int) -> None:
    assert loaded(running, table_file(size, shift)) == "load refused worse_prediction"
    assert place_words(running)[0] == 0


def test_a_table_that_the_core_lacks_or_that_is_too_steep_is_refused(running: Firmware) -> None:
    answers = send(running, load_frames(table_file()))
    assert any(answer.startswith("error: load no_local_table") for answer in answers)
    assert state(running) != "load waiting"
    built(running)
    one = LocalTable((0, 100_000), (0,), 6, 4)
    steep = dataclasses.replace(file_of({}), extension=Extension(local_table=one))
    assert one.steepest(COUNTS) > 1.0
    *_, last = send(running, load_frames(steep))
    assert last.startswith("error: load too_steep")


def starting(starts: tuple[int, ...], width_exponent: int, first: int = 0) -> Coefficients:
    """Return coefficients with a table of zeros, except that each window begins with the word
    ``first``, in 1/16 count."""
    points = np.zeros((len(starts), POINTS // len(starts)), dtype=np.int64)
    points[:, 0] = first
    table = LocalTable(tuple(points.ravel().tolist()), starts, width_exponent, 4)
    return dataclasses.replace(file_of({}), extension=Extension(local_table=table))


WINDOW = COUNTS >> 6


@pytest.mark.parametrize(
    ("starts", "width", "taken"),
    [
        ((0, WINDOW + 1), 6, True),
        ((WINDOW + 1, 0), 6, True),
        ((COUNTS - WINDOW - 1, 0, 5 * WINDOW, COUNTS - WINDOW - 1), 6, True),
        ((0, WINDOW), 6, False),
        ((0, WINDOW // 2), 6, False),
        ((0, COUNTS - WINDOW), 6, False),
        ((0, 3 * WINDOW, 6 * WINDOW, 6 * WINDOW + 1), 6, False),
        ((0, COUNTS // 2), 0, False),
        ((7, 7), 0, True),
    ],
)
def test_windows_that_overlap_or_touch_are_refused(
    running: Firmware, starts: tuple[int, ...], width: int, taken: bool
) -> None:
    """The first window that contains a reading gives the value. Where a window ends inside or next
    to another one, the value would jump from one window's points to the other's; the bound of the
    slope does not contain this jump. A window that begins like an earlier one is never used."""
    built(running)
    whole = starting((0,), 6)
    assert whole.extension is not None
    assert whole.extension.local_table is not None
    held = dataclasses.replace(whole.extension.local_table, starts_counts=starts)
    words = Bank.of_file(dataclasses.replace(held, width_exponent=width), COUNTS).place_words()
    numbers = words[:5]
    crc = zlib.crc32(struct.pack("<5I", *numbers))
    send(running, load_frames(whole)[:1])
    line = f"load table {' '.join(map(str, numbers))} {crc:08X}"
    (answer,) = send(running, [line])
    assert answer == ("ok" if taken else "error: load out_of_range")
    if taken:
        assert starting(starts, width).extension is not None
    else:
        with pytest.raises(ValueError, match="overlap"):
            starting(starts, width)


@pytest.mark.parametrize(("first", "answer"), [(15, "ok"), (16, "error: load too_steep")])
def test_the_leap_at_the_ends_of_a_window_is_bounded(
    running: Firmware, first: int, answer: str
) -> None:
    """At the first count of a window the value rises from 0 to the first point. This point must be
    below one count; otherwise the corrected angle would stop or turn back."""
    built(running)
    leaping = starting((0, 4 * WINDOW), 6, first)
    assert send(running, load_frames(leaping))[-1] == answer
    assert (of_limits(leaping) == []) == (answer == "ok")


def test_a_missing_or_changed_frame_spoils_the_whole(running: Firmware) -> None:
    built(running)
    frames = load_frames(table_file())
    for number in (2, 400):
        short = [frame for place, frame in enumerate(frames) if place != number]
        assert send(running, short)[-1] != "ok"
        assert state(running) != "load waiting"


def test_a_set_without_a_table_switches_it_off(running: Firmware) -> None:
    assert loaded(running, table_file()) == "load active"
    send(running, load_frames(file_of({})))
    running.turn(turn(9, disc=SCRATCHED))
    assert place_words(running)[0] == 0
    assert state(running) == "load none"


def test_a_table_from_before_a_fault_of_the_firmware_is_switched_off(running: Firmware) -> None:
    """The restarted firmware has no record of the table that the gateware still applies, and
    switches this table off."""
    assert loaded(running, table_file()) == "load active"
    anew = Firmware(running.core)
    anew.library.application_start(anew.application)
    running.core.see_index()
    anew.send("set orders 8")
    anew.step()
    assert place_words(anew)[0] != 0
    for seed in range(20, 24):
        anew.turn(turn(seed, disc=SCRATCHED))
    assert place_words(anew)[0] == 0


@pytest.mark.parametrize("is_kept", [True, False])
def test_after_a_rearm_the_gateware_must_still_hold_it(running: Firmware, is_kept: bool) -> None:
    assert loaded(running, table_file()) == "load active"
    running.send("rearm")
    if not is_kept:
        running.core.words[LOCAL_POINTS_ADDRESS + 4 * 2000] ^= 1
    running.core.see_index()
    running.step()
    for seed in range(20, 24):
        running.turn(turn(seed, disc=SCRATCHED))
    assert state(running) == ("load active" if is_kept else "load refused not_whole")
    assert (place_words(running)[0] != 0) == is_kept


@pytest.mark.parametrize("disc", [OPPOSITE, DISC], ids=["opposite", "none"])
def test_after_a_rearm_a_turn_that_contradicts_it_rejects_it(running: Firmware, disc: Disc) -> None:
    assert loaded(running, table_file()) == "load active"
    running.send("rearm")
    running.core.see_index()
    running.step()
    for seed in range(20, 23):
        running.turn(turn(seed, disc=disc))
    assert state(running) == "load refused worse_prediction"
    assert place_words(running)[0] == 0


@pytest.mark.parametrize("disc", [OPPOSITE, DISC], ids=["opposite", "none"])
def test_turns_that_contradict_the_active_table_raise_the_alarm(
    running: Firmware, disc: Disc
) -> None:
    """With the scratch that the table corrects, there is no alarm; with the opposite or without a
    scratch, the alarm comes in the first turn, and ends when the scratch returns."""
    # The scratch also increases the noise of the fit.
    for limit in ("alarm_error_arcsec 100", "alarm_noise_arcsec 10"):
        running.send(f"set {limit}")
    assert loaded(running, table_file()) == "load active"

    def alarms(seeds: range, disc: Disc) -> list[list[str]]:
        return [running.turn(turn(seed, disc=disc))["alarms"] for seed in seeds]

    assert alarms(range(20, 26), SCRATCHED) == [[]] * 6
    assert alarms(range(26, 29), disc) == [["error"]] * 3
    assert alarms(range(29, 31), SCRATCHED) == [[]] * 2
    # Half of the points of another table are in the idle bank: the table is not judged by them.
    frames = load_frames(table_file(-1.0))
    first = next(n for n, frame in enumerate(frames) if frame.startswith("load points "))
    assert set(send(running, frames[: first + 450])) == {"ok"}
    assert alarms(range(31, 32), SCRATCHED) == [[]]


def points_of(running: Firmware) -> list[int]:
    return [running.core.words.get(LOCAL_POINTS_ADDRESS + 4 * at, 0) for at in range(POINTS)]


def saved_board() -> Board:
    board = Board()
    board.firmware.send("set orders 8")
    board.work(range(1, 5), disc=SCRATCHED)
    assert loaded(board.firmware, table_file()) == "load active"
    return board


def after_power_off(board: Board) -> Firmware:
    board.power_on()
    built(board.firmware)
    return board.firmware


def test_a_saved_table_outlives_the_power() -> None:
    """The first turn that shows the scratch confirms the saved table; the words of the table equal
    the loaded words."""
    board = saved_board()
    words = points_of(board.firmware)
    assert board.order("save").startswith("ok, record 1")
    running = after_power_off(board)
    assert board.status("saved") == ["waiting"]
    assert place_words(running)[0] == 0
    board.work(range(9, 11), disc=SCRATCHED)
    assert board.status("saved") == ["confirmed"]
    assert state(running) == "load active"
    assert place_words(running) == bank_of(table_file()).place_words()
    assert points_of(running) == words
    # The next save reads the table back from the gateware.
    assert board.order("save").startswith("ok, record 2")
    # After a file without a table has been loaded, the next record contains none.
    send(running, load_frames(file_of({})))
    board.work(range(11, 13), disc=SCRATCHED)
    assert board.order("save").startswith("ok, record 3")
    after_power_off(board)
    board.work(range(13, 15), disc=SCRATCHED)
    assert place_words(board.firmware)[0] == 0


def test_a_saved_table_that_the_disc_contradicts_is_not_taken() -> None:
    board = saved_board()
    board.order("save")
    running = after_power_off(board)
    board.work(range(9, 11), disc=DISC)
    assert board.status("saved") == ["not_confirmed"]
    assert place_words(running)[0] == 0


@pytest.mark.parametrize("damage", ["flash", "generic"])
def test_a_table_that_cannot_be_restored_is_not_taken(damage: str) -> None:
    board = saved_board()
    board.order("save")
    board.power_on()
    if damage == "flash":
        built(board.firmware)
        data = bytes(board.chip.content)
        wanted = table_file()
        middle = int(bank_of(wanted).points[POINTS // 2]).to_bytes(4, "little")
        at = data.index(middle)
        board.chip.content[at] ^= 1
    board.work(range(9, 11), disc=SCRATCHED)
    assert board.status("saved") == ["not_confirmed"]
    assert place_words(board.firmware)[0] == 0


def half_load(board: Board, end: str) -> None:
    """Load half of the points of another table, and end this load with the line ``end``."""
    frames = load_frames(table_file(0.5))
    first = next(n for n, frame in enumerate(frames) if frame.startswith("load points "))
    assert set(send(board.firmware, frames[: first + 450])) == {"ok"}
    if end:
        assert board.firmware.send(end).strip() == "ok"


@pytest.mark.parametrize("end", ["load abort", ""], ids=["aborted", "still arriving"])
def test_a_save_does_not_drop_the_table_that_another_load_overwrote(end: str) -> None:
    """The active table stays active, but its points are lost for the record: the firmware refuses
    the save until the table is loaded again."""
    board = saved_board()
    half_load(board, end)
    assert board.order("save") == "error: save table_not_held\r\n"
    assert "load the table again" in board.firmware.send("help table_not_held")
    assert board.chip.programmed == []
    assert loaded(board.firmware, table_file()) == "load active"
    assert board.order("save").startswith("ok, record 1")
    running = after_power_off(board)
    board.work(range(9, 11), disc=SCRATCHED)
    assert board.status("saved") == ["confirmed"]
    assert place_words(running) == bank_of(table_file()).place_words()


@pytest.mark.parametrize("set_waits", [False, pytest.param(True, marks=pytest.mark.large)])
def test_a_save_takes_the_points_from_the_record_before(set_waits: bool) -> None:
    """If an aborted load has overwritten the points, the firmware takes them from the latest
    record, which holds the same table. It does so also while a received set without a table
    waits."""
    board = saved_board()
    words = points_of(board.firmware)
    assert board.order("save").startswith("ok, record 1")
    half_load(board, "load abort")
    assert points_of(board.firmware) != words
    if set_waits:
        assert set(send(board.firmware, load_frames(file_of({})))) == {"ok"}
    assert board.order("save").startswith("ok, record 2")
    running = after_power_off(board)
    board.work(range(9, 11), disc=SCRATCHED)
    assert board.status("saved") == ["confirmed"]
    assert points_of(running) == words


def test_a_save_before_the_first_turn_keeps_the_table_that_waits() -> None:
    board = saved_board()
    words = points_of(board.firmware)
    assert board.order("save").startswith("ok, record 1")
    after_power_off(board)
    assert board.status("saved") == ["waiting"]
    assert board.order("save").startswith("ok, record 2")
    running = after_power_off(board)
    board.work(range(9, 11), disc=SCRATCHED)
    assert board.status("saved") == ["confirmed"]
    assert points_of(running) == words


def test_a_save_into_a_silent_flash_leaves_the_table_that_waits() -> None:
    """The table of record 2 waits after a save fails: the firmware reads the points of record 2
    only at the first turn, and not from the first sector, which the test erases."""
    board = saved_board()
    words = points_of(board.firmware)
    for record in (1, 2):
        assert board.order("save").startswith(f"ok, record {record}")
    running = after_power_off(board)
    board.chip.content[REGION.start : REGION.start + (1 << 15)] = b"\xff" * (1 << 15)
    board.chip.fault = "silent"
    assert board.order("save") == "error: save flash_unknown\r\n"
    board.chip.fault = ""
    board.work(range(9, 11), disc=SCRATCHED)
    assert board.status("saved") == ["confirmed"]
    assert points_of(running) == words


def test_no_points_arrive_while_a_record_is_written() -> None:
    """While the firmware writes a record, it reads the table's points back from the gateware;
    therefore it accepts no new points."""
    board = saved_board()
    board.firmware.send("save")
    frames = load_frames(table_file(0.5))
    answers = send(board.firmware, frames[:4])
    assert answers[-1].startswith("error: load wrong_frame")
    assert board.order("").startswith("ok, record 1")


@pytest.mark.parametrize(
    "steps",
    [pytest.param(52, marks=pytest.mark.large), 70, pytest.param(100, marks=pytest.mark.large)],
)
def test_power_that_is_lost_while_points_are_written_leaves_the_record_before(steps: int) -> None:
    """The previous record stays valid if power is lost while points are written. The erase takes
    0.52 s, which is 52 steps; then the firmware programs 64 pages of points, and after these the
    pages of the record."""
    board = Board()
    board.firmware.send("set orders 8")
    board.work(range(1, 5), disc=SCRATCHED)
    assert board.order("save").startswith("ok, record 1")
    assert loaded(board.firmware, table_file()) == "load active"
    board.firmware.send("save")
    for _ in range(steps):
        board.controller.now_us += 10_000
        assert board.firmware.step() == "", "the save is under way"
    running = after_power_off(board)
    assert board.status("saved") == ["waiting"]
    board.work(range(9, 11), disc=SCRATCHED)
    assert board.status("saved") == ["confirmed"]
    assert place_words(running)[0] == 0


def test_the_table_of_a_mean_of_four_heads_is_loaded_with_it() -> None:
    """The firmware loads the local table of a mean of four heads with the mean, because turns of
    two heads judge neither the table nor the lanes. The local table has a window for each head."""
    running = Firmware(prepared.FailoverCore())
    running.library.application_start(running.application)
    running.core.see_index()
    running.send("set orders 8")
    running.step()
    core = running.core
    core.set("capability", core.get("capability") | LOCAL_TABLE)
    running.turn(turn(1))
    starts = (0, COUNTS // 4, COUNTS // 2, 3 * COUNTS // 4)
    bells = np.rint(np.outer([9000, 7000, -3000, 5000], np.hanning(1024))).astype(np.int64)
    table = LocalTable(tuple(bells.ravel().tolist()), starts, 6, 8)
    plain = prepared.file_of()
    assert plain.extension is not None
    extension = dataclasses.replace(plain.extension, local_table=table)
    wanted = dataclasses.replace(plain, extension=extension)
    prepared.loaded(running, wanted)
    assert place_words(running) == bank_of(wanted).place_words()
    assert points_of(running) == [point & 0xFFFF_FFFF for point in table.points]
