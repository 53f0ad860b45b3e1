"""Tests the general commands of the console, and lines that are not commands; the other commands
have their own test modules."""

from __future__ import annotations

import io
import json
import struct
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sim.tests.firmware.calibrator import BOTH_INDICES_SEEN, capture_in_c
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import Firmware, ModelCore
from sim.tests.firmware.test_application import turn

COMMANDS = ("help", "status", "version", "show harmonics", "show parameters", "dump", "freeze on")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_answers(running: Firmware, command: str) -> None:
    answer = running.send(command)
    assert answer.endswith("\r\n")
    assert answer.splitlines()[-1].startswith("ok")


def test_version_tells_firmware_gateware_and_chip(running: Firmware) -> None:
    """The answer to version consists of exactly these lines. They come from the build and from the
    core's registers for version, configuration, clock, pipeline, capability and chip DNA."""
    core, (ffi, _) = running.core, firmware()
    core.set("version", 3 << 16 | 21 << 8 | 7)
    core.set("pipeline", 30 << 8 | 8)
    core.set("chip_dna_low", 0x89ABCDEF)
    names = [ffi.new("char[]", word) for word in (b"1.2.3", b"0123456789ab")]
    running.console.firmware, running.console.build = names
    printed = running.send("version").splitlines()
    assert printed == [
        "firmware 1.2.3",
        "build 0123456789ab",
        "gateware 3.21.7",
        "lanes 32",
        "fold 8",
        "rotation cordic",
        "capture_depth 12288",
        "clock_hz 100000000",
        "dna unknown",
        "ok",
    ]
    core.set("capability", 1 << 4 | 2)
    assert "rotation table" in running.send("version").splitlines()
    # The gateware of an earlier minor version does not have this register.
    core.set("version", 3 << 16 | 7 << 8)
    assert "rotation cordic" in running.send("version").splitlines()
    core.set("chip_dna_high", 1 << 31 | 0x1234567)
    assert "dna 0x0123456789ABCDEF" in running.send("version").splitlines()


def test_version_without_a_core() -> None:
    idle = Firmware(ModelCore())
    assert idle.send("version").splitlines() == [
        "firmware unknown",
        "build unknown",
        "gateware none",
        "ok",
    ]


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("hlep", "error: no such command, try help: hlep"),
        (
            "show",
            "error: use: show harmonics | show parameters | show heads: all data of each head",
        ),
        ("show all", "error: expected show harmonics, parameters or heads, not all"),
        ("set keep", "error: use: set PARAMETER VALUE"),
        ("set keep 1e3", "error: not a decimal number: 1e3"),
        ("set keep 1.0.0", "error: not a decimal number: 1.0.0"),
        ("set keep nan", "error: not a decimal number: nan"),
        ("set keep -", "error: not a decimal number: -"),
        ("set keep 1.5", "error: keep takes 0.00 to 1"),
        ("set orders 41", "error: orders takes 1.00 to 40"),
        ("set orders 3.5", "error: expected a whole number, not 3.5"),
        ("set colour 1", "error: no parameter colour"),
        ("bypass maybe", "error: expected on or off, not maybe"),
        ("a b c d e f g h i j", "error: the line is too long or is not text; try help"),
        ("x" * 81, "error: the line is too long or is not text; try help"),
        ("x" * 5000, "error: the line is too long or is not text; try help"),
        ("st\x01atus", "error: the line is too long or is not text; try help"),
    ],
)
def test_bad_input_gets_one_line(running: Firmware, line: str, answer: str) -> None:
    assert running.send(line) == answer + "\r\n"
    assert running.send("freeze off") == "ok\r\n", "the next line is processed"


def test_every_reason_and_alarm_is_explained(running: Firmware) -> None:
    ffi, library = firmware()
    reasons = [library.refusal_name(reason) for reason in range(1, library.REFUSALS)]
    alarms = [name for bit in range(32) if (name := library.alarm_name(1 << bit)) != ffi.NULL]
    assert len(alarms) == 17
    for name in {ffi.string(name).decode() for name in (*reasons, *alarms)}:
        answer = running.send(f"help {name}").splitlines()
        # `temperature` is also the name of a command.
        assert len(answer) == 2 + (name == "temperature"), name
        assert len(answer[-2].split()) >= 5, "a sentence"
        assert answer[-1] == "ok"


def test_help_with_a_word(running: Firmware) -> None:
    assert running.send("help set") == "set PARAMETER VALUE\r\nok\r\n"
    assert running.send("help heads_exchanged").startswith("head 2 is where head 1 should be")
    assert running.send("help me") == "error: no command, reason or alarm me\r\n"


def test_status_tells_what_to_do(running: Firmware) -> None:
    assert "advice" not in running.send("status")
    running.turn(turn())
    assert "advice" not in running.send("status")
    bad = turn(seed=2)
    bad[1] = -bad[1]
    assert running.turn(bad)["reason"] == "inconsistent_heads"
    advice = "advice the heads count in different directions: exchange A and B"
    assert advice in running.send("status")
    running.send("set alarm_noise_arcsec 0.001")
    running.turn(turn(seed=3))
    assert "alarm noise\r\nadvice the turn is much noisier than usual" in running.send("status")


def test_editing_and_empty_lines(running: Firmware) -> None:
    assert running.send(b"fre\x7f\x08\x08\x08\x08freeze  on \r") == "ok\r\n"
    assert running.send(b"\r\n\r\n   \r") == ""


def test_parameters_are_set(running: Firmware) -> None:
    assert running.send("set keep 0.25") == "ok\r\n"
    assert running.application.parameters.keep == 0.25
    assert "keep 0.250000000\r\n" in running.send("show parameters")
    assert running.send("set sample_period 34") == "ok, waiting for the index again\r\n"
    assert running.core.get("sample_period") == 34
    assert running.phase == "wait_for_index"


def test_a_whole_parameter_is_shown_as_the_whole_number(running: Firmware) -> None:
    """The console shows whole parameters without decimals over their whole range: a delay of head 4
    of 54 clocks is 54 · 2²⁴ > 9e8, which a number with nine decimals cannot show."""
    for value in (0, 54 << 24, (1 << 32) - 1):
        assert running.send(f"set head_delays {value}").startswith("ok")
        assert f"\r\nhead_delays {value}\r\n" in running.send("show parameters")


@pytest.mark.parametrize(("name", "most"), [("ramp_arcsec_s", 10**9), ("ramp_arcsec_s2", 10**12)])
def test_the_largest_ramp_is_shown(running: Firmware, name: str, most: int) -> None:
    for value, shown in ((most, f"{most}"), (9e8, "900000000"), (8e8, "800000000.000000000")):
        assert running.send(f"set {name} {value:.0f}").startswith("ok")
        assert f"\r\n{name} {shown}\r\n" in running.send("show parameters")


def test_the_core_is_looked_for_again(running: Firmware) -> None:
    assert running.send("rearm") == "ok, waiting for the index again\r\n"
    assert running.phase == "wait_for_index"
    running.core.set("identification", 0)
    assert running.send("rearm") == "error: no core answers\r\n"
    assert running.phase == "no_core"


def test_harmonics_are_shown_as_they_were_found(running: Firmware) -> None:
    running.turn(turn())
    lines = running.send("show harmonics").splitlines()
    rows = [line.split() for line in lines[1:-1]]
    assert len(rows) == 32
    harmonic = running.application.estimate.harmonic
    for place, (order, cosine, sine, _, verdict) in enumerate(rows):
        assert int(order) == place + 1
        assert float(cosine) == pytest.approx(harmonic[place].cosine, abs=6e-10)
        assert float(sine) == pytest.approx(harmonic[place].sine, abs=6e-10)
        assert verdict in ("applied", "not_significant")


def test_harmonics_of_a_refused_turn_are_not_shown(running: Firmware) -> None:
    running.turn(turn())
    good = running.send("show harmonics")
    assert running.turn(turn(seed=2, noise=5.0))["reason"] == "noise"
    assert running.send("show harmonics") == good
    (noise,) = [
        line for line in running.send("status").splitlines() if line.startswith("noise_arcsec")
    ]
    refused = 5.0 * np.sqrt(2.0)
    # 1,500 samples determine the noise to 2 %.
    assert float(noise.split()[1]) == pytest.approx(refused, rel=0.1)


def test_a_dump_is_the_capture(running: Firmware) -> None:
    running.send("dump")
    counts = turn()
    counts[1, 7] = -5
    running.core.hand_over(counts)
    said = running.step(2 + counts.shape[1] // 8)
    head, *rows, end = said.splitlines()
    assert head.startswith("dump sequence=1 samples=1501 counts_per_rev=16777216 clock_hz=1000000")
    assert rows[0] == "row,head1_counts,head2_counts,crc"
    assert end == "end of dump"
    table = np.loadtxt(io.StringIO("\n".join(rows[1:])), delimiter=",", usecols=(0, 1, 2))
    np.testing.assert_array_equal(table[:, 0], np.arange(counts.shape[1]))
    np.testing.assert_array_equal(table[:, 1:], counts.T)
    for row in rows[1:]:
        number, head1, head2, crc = row.split(",")
        words = struct.pack("<Iqq", int(number), int(head1), int(head2))
        assert int(crc, 16) == zlib.crc32(words)
    assert running.send("dump rows 7 2") == "ok\r\n"
    assert running.step(1).splitlines() == [*rows[8:10], "end of dump"]
    for bad in ("dump rows 1500 2", "dump rows -1 2", "dump rows 0 0", "dump rows a b"):
        assert running.send(bad) == "error: no such rows\r\n"
    assert running.phase == "capture"
    assert running.application.turns == 1, "the dumped turn is also processed"


def test_the_turns_go_on_while_a_capture_is_reported(running: Firmware) -> None:
    """The firmware gives the bank back to the core at once; the console prints a copy, eight rows
    per step."""
    running.send("dump")
    running.send("telemetry on")
    counts = turn()
    running.core.hand_over(counts)
    said, turns = running.step(4), 0
    while "end of dump" not in said:
        assert running.library.console_busy(running.console)
        if not running.core.get("status"):
            turns += 1
            running.core.hand_over(turn(seed=turns + 1))
        said += running.step(4)
    assert turns > 5
    printed = [line for line in said.splitlines() if line.startswith("{")]
    assert len(printed) >= turns
    assert all('"alarms":[]' in line for line in printed), "no overrun"
    rows = [line.split(",") for line in said.splitlines() if line[0].isdigit()]
    found = np.array([[int(row[1]), int(row[2])] for row in rows]).T
    np.testing.assert_array_equal(found, counts)


@pytest.mark.parametrize("heads", [2, 3, 4])
@pytest.mark.parametrize("samples", [3, 3072, 3073, 6144, 6145, 12_287, 12_288])
@pytest.mark.parametrize("sense", [1, -1])
def test_a_copy_has_every_sample(samples: int, sense: int, heads: int) -> None:
    """The copy stores a few samples in full, and many samples as steps of 16 bits. The rows are
    read in any order and across a wrap at 2³¹.

    With more than two heads and more than 6,144 samples, the copy contains every second sample.
    """
    ffi, library = firmware()
    draw = np.random.default_rng(samples)
    every = 2 if heads > 2 and samples > 6144 else 1
    step = min(30_000, (1 << 24) // samples) // every
    head1 = 2**31 - 5_000 + sense * np.cumsum(draw.integers(step // 2, step, samples))
    ahead = 1_500_000 * np.arange(1, heads)[:, np.newaxis]
    others = head1 + ahead + draw.integers(-15_000, 15_000, (heads - 1, samples))
    counts = np.vstack([head1, others])
    capture = capture_in_c(counts)
    copy = ffi.new("struct capture_copy *")
    assert library.capture_copy_take(copy, capture.capture)
    assert copy.heads == heads
    kept = -(-samples // every)
    assert copy.samples == kept
    assert copy.period_clocks == every * capture.capture.period_clocks
    for sample in (*range(0, kept, max(1, kept // 50)), kept - 1, 0, kept // 2):
        found = ffi.new("int64_t[4]")
        library.capture_copy_counts(copy, sample, found)
        asked = library.capture_counts(capture.capture, every * sample)
        assert list(found)[:2] == [asked.head1, asked.head2]
        row = counts[:, every * sample] - counts[:, 0]
        first = [int(place) % (1 << 24) for place in counts[2:, 0]]
        assert list(found)[2:heads] == (row[2:] + first).tolist()


@pytest.mark.parametrize("heads", [2, 3, 4])
def test_places_of_heads_equal_numpy(heads: int) -> None:
    """Compare the mean distance of each head from head 1 over a turn with numpy, to 1e-7 count; the
    turn has 16 million counts. The C code gives no result if head 3 has a fault or no index."""
    ffi, library = firmware()
    turn = 1 << 24
    draw = np.random.default_rng(heads)
    true = np.arange(12_000) * (turn / 12_000)
    ahead = np.array([0, 2_996_597, 8_248_798, 12_019_011])[:heads, np.newaxis]
    counts = np.rint(true + ahead + draw.normal(0, 800, (heads, 12_000))).astype(np.int64)
    further_seen = (1 << (heads - 2)) - 1 << 10
    capture = capture_in_c(counts, flags=BOTH_INDICES_SEEN | further_seen)
    capture.capture.start = [int(row[0]) % turn for row in counts] + [0] * (4 - heads)
    place = ffi.new("double[4]")
    assert library.capture_places(capture.capture, 12_000, place)
    expected = (counts - counts[0]).mean(axis=1) % turn
    np.testing.assert_allclose(list(place)[:heads], expected, rtol=0, atol=1e-7)
    if heads > 2:
        capture.capture.flags = BOTH_INDICES_SEEN | further_seen | 1 << 14
        assert not library.capture_places(capture.capture, 12_000, place), "illegal of head 3"
        capture.capture.flags = BOTH_INDICES_SEEN
        assert not library.capture_places(capture.capture, 12_000, place), "no index of head 3"


def test_a_turn_whose_steps_do_not_fit_is_not_copied() -> None:
    ffi, library = firmware()
    head1 = np.arange(7000) * 1000
    head1[3000:] += 40_000
    capture = capture_in_c(np.array([head1, head1]))
    copy = ffi.new("struct capture_copy *")
    assert not library.capture_copy_take(copy, capture.capture)
    assert copy.samples == 0


@given(st.binary(max_size=400))
@settings(max_examples=150, deadline=None)
def test_a_flood_of_bytes_does_no_harm(flood: bytes) -> None:
    made = Firmware(ModelCore())
    made.library.application_start(made.application)
    answer = made.send(flood + b"\r")
    assert answer == "" or answer.endswith("\r\n")
    assert "turns 0" in made.send("status")


@given(st.floats(-8e8, 8e8), st.integers(0, 9))
@settings(max_examples=200, deadline=None)
def test_numbers_are_written_right(value: float, decimals: int) -> None:
    ffi, library = firmware()
    made = Firmware(ModelCore())
    made.said.clear()
    library.text_fixed(made.sink, value, decimals)
    text = made.said.decode()
    # The bound is half a unit of the last decimal, plus the rounding error of value * 10^decimals.
    assert abs(float(text) - value) <= 0.5 * 10.0**-decimals + abs(value) * 3e-16
    assert len(text.partition(".")[2]) == decimals
    parsed = ffi.new("double *")
    if len(text.strip("-").replace(".", "")) <= 15:
        assert library.text_parse_decimal(text.encode(), parsed)
        assert parsed[0] == pytest.approx(float(text), rel=1e-15)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1e9, 1e300])
def test_what_is_no_number_is_null(value: float) -> None:
    made = Firmware(ModelCore())
    made.said.clear()
    firmware()[1].text_fixed(made.sink, value, 3)
    assert made.said == b"null"


@given(st.integers(-(2**63), 2**63 - 1))
@settings(deadline=None)
def test_whole_numbers(value: int) -> None:
    made = Firmware(ModelCore())
    made.said.clear()
    firmware()[1].text_signed(made.sink, value)
    assert made.said.decode() == str(value)


@given(st.integers(0, 2**32 - 1))
@settings(deadline=None)
def test_addresses(value: int) -> None:
    made = Firmware(ModelCore())
    made.said.clear()
    firmware()[1].text_hexadecimal(made.sink, value)
    assert made.said.decode() == f"{value:08X}"


def test_what_the_board_knows_is_reported(running: Firmware) -> None:
    ffi, _ = firmware()
    plain = running.send("status")
    assert "reset none\r\n" in plain
    assert "reset_instruction" not in plain
    assert "fabric" not in plain
    reason, loaded = ffi.new("char[]", b"hang"), ffi.new("char[]", b"loaded")
    fabric = ffi.callback("console_word", lambda: loaded)
    running.console.reset_reason, running.console.fabric = reason, fabric
    running.console.overruns = 3
    running.console.reset_instruction = 0x1A2C
    printed = running.send("status")
    assert "console_overruns 3\r\n" in printed
    assert "reset hang\r\nreset_instruction 0x00001A2C\r\nfabric loaded\r\n" in printed


UART_OUTPUT_RING = 4096
"""Size of the output ring of board/uart.h, in characters."""


class Room:
    """A port that accepts only a limited number of characters at once."""

    def __init__(self, made: Firmware, characters: int) -> None:
        self.characters = characters
        self._call = firmware()[0].callback("text_room", lambda _: self.characters)
        made.console.sink.room = self._call


def test_a_line_for_which_there_is_no_room_is_left_out_whole(running: Firmware) -> None:
    """The console omits a whole line for which there is no room: no line waits and none is cut. The
    next line reports the alarms of the omitted line."""
    running.send("telemetry on")
    running.send("set alarm_noise_arcsec 0.000001")
    running.core.hand_over(turn(seed=1))
    length = len(running.step(4))
    running.send("set alarm_noise_arcsec 60")
    running.send("set alarm_separation_arcsec 0.000001")
    room = Room(running, length - 400)
    running.core.hand_over(turn(seed=2))
    assert running.step(4) == ""
    running.send("set alarm_separation_arcsec 600")
    room.characters = length + 400
    running.core.hand_over(turn(seed=3))
    printed = json.loads(running.step(4))
    assert (printed["turn"], printed["alarms"]) == (3, ["separation"])
    assert "telemetry_overruns 1\r\n" in running.send("status")
    running.core.hand_over(turn(seed=4))
    assert json.loads(running.step(4))["alarms"] == [], "once"


def test_the_longest_line_of_telemetry_has_room_in_the_ring(running: Firmware) -> None:
    """The ring has room for a line in which every number has its greatest length and every alarm is
    on; the console can never send a longer line."""
    ffi, library = firmware()
    running.core.hand_over(turn(seed=1))
    running.step(4)
    application = running.application
    application.estimate.orders = library.ORDERS_MAX
    for place in range(library.ORDERS_MAX):
        application.estimate.harmonic[place].cosine = -8.9e8
        application.estimate.harmonic[place].sine = 1e-9
        application.estimate.harmonic[place].by_separation_cosine = 8e8
    application.report.alarms = 0xFFFF_FFFF
    application.report.between_turns = False
    said: list[int] = []
    put = ffi.callback("text_put", lambda _, __, number: said.append(number))
    sink = ffi.new("struct text_sink *", [put, ffi.NULL, ffi.NULL])
    assert library.telemetry_turn(sink, application, 0xFFFF_FFFF)
    assert 2000 < sum(said) < UART_OUTPUT_RING


def test_a_dump_goes_on_as_there_is_room(running: Firmware) -> None:
    running.send("dump")
    running.core.hand_over(turn(seed=1))
    running.step(2)
    room = Room(running, 63)
    assert running.step(5) == ""
    assert not running.library.console_busy(running.console), (
        "the firmware may sleep until there is room"
    )
    room.characters = 64
    assert running.library.console_busy(running.console)
    assert len(running.step(1).splitlines()) == 8
