"""Tests how prepared sets are loaded over the console, and how the firmware uses them when a head
fails. A prepared set holds the coefficients and weights of the mean without one head.

The model of the core has four heads. Heads 3 and 4 repeat the readings of heads 1 and 2, because
the firmware's check of places and its telemetry need four readings but no simulated table.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sim.tests.calibration.synthetic import COUNTS
from sim.tests.firmware.calibrator import BOTH_INDICES_SEEN
from sim.tests.firmware.model_core import Firmware, ModelCore, address, bit, field_shift
from sim.tests.firmware.test_load import load, send, state, turn

from arctrue.calibration.acceptance import of_limits
from arctrue.device.load import heads_without_sets, load_frames
from arctrue.gateware.capability import Capability
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import POINTS, Conditions, LocalTable
from arctrue.gateware.mean_set import MeanSet
from arctrue.gateware.parity_sum import parity_weights
from arctrue.gateware.register_access import RegisterMap

HEADS = 4
LOCAL_TABLE = 1 << 7
LANES = 32
SEPARATION_DEG = 33.0
ALPHA = round(SEPARATION_DEG / 360.0 * COUNTS * 16)
OFFSETS = (0, ALPHA, 0, ALPHA)
WEIGHTS = (20_000, 15_000, 17_000, 13_536)
WINDOW = 0x1000
FIRST_WINDOW = 0x8000
MEAN = 0x1800
FURTHER_INDICES_SEEN = 0b11 << 10
CAUSES = ("illegal", "overspeed", "swallowed", "missing_edges", "step", "index")


class FailoverCore(ModelCore):
    """A model of the core with the failover registers; the model accepts prepared sets, and failed
    heads can return."""

    def __init__(self) -> None:
        super().__init__()
        self.set("version", 0x000800)
        self.set("capability", HEADS | 1 << 3 | bit("capability", "failover"))
        self.access.further_capture = self.access.capture
        self.status(left_out=0, active=7)

    def status(self, *, left_out: int, active: int, cause: int = 0) -> None:
        shown = left_out | active << 4 | 0b1111 << 8 | cause << field_shift("heads_status", "cause")
        self.set("heads_status", shown)

    def write(self, context: Any, offset: int, word: int) -> None:
        super().write(context, offset, word)
        if offset == address("heads_command") and word & 1 << 7:
            number = word >> 4 & 7
            self.status(left_out=1 << number >> 1, active=number)
            self.set("swap_count", self.get("swap_count") + 1)

    def command(self, word: int) -> None:
        super().command(word)
        if word & bit("command", "swap"):
            left_out = self.get("heads_status") & 0b1111
            self.status(left_out=left_out, active=7)

    def hand_over(self, counts: Any, flags: int = BOTH_INDICES_SEEN, travel: int = 0) -> None:
        super().hand_over(counts, flags | FURTHER_INDICES_SEEN, travel)
        for head, row in enumerate((0, 1, 0, 1), start=1):
            position = int(counts[row, -1])
            turn_position = f"snapshot.head{head}_turn_position"
            angle = f"snapshot.head{head}_angle"
            if head > 2:
                turn_position, angle = f"head{head}.turn_position", f"head{head}.angle"
            self.set(turn_position, position)
            self.set(angle, position % COUNTS)

    def window(self, number: int) -> dict[int, int]:
        """Return the words of a prepared set, keyed by their offset in the window."""
        first = FIRST_WINDOW + WINDOW * number
        return {at - first: self.words[at] for at in self.words if 0 <= at - first < WINDOW}


def lanes_of(amplitude: float) -> Coefficients:
    return Coefficients.from_harmonics([3, 7], [amplitude, 0.5], [0.3, 1.9], COUNTS, LANES)


def without(missing: int) -> Coefficients:
    """Return a set whose weights all differ. The carrier, the head whose counts the mean follows,
    is head 1 unless this head is missing."""
    weights = [0 if head == missing else 10_000 * head for head in range(1, HEADS + 1)]
    carrier = 2 if missing == 1 else 1
    weights[carrier - 1] += 65_536 - sum(weights)
    mean = MeanSet(tuple(weights), OFFSETS, carrier, missing)
    return replace(lanes_of(2.0 + missing), offset=missing, extension=Extension(mean=mean))


def file_of(*missing: int) -> Coefficients:
    mean = MeanSet(WEIGHTS, OFFSETS)
    sets = tuple(without(head) for head in missing)
    return replace(lanes_of(1.0), extension=Extension(mean=mean, without=sets))


@pytest.fixture
def running() -> Firmware:
    made = Firmware(FailoverCore())
    made.library.application_start(made.application)
    made.core.see_index()
    made.send("set orders 8")
    made.step()
    made.turn(turn(1))
    return made


def loaded(running: Firmware, coefficients: Coefficients) -> None:
    assert load(running, coefficients) == "ok"
    running.turn(turn(2))
    running.step(3)
    assert state(running) == "load active"


def words_by(coefficients: Coefficients, mean: MeanSet, number: int) -> dict[int, int]:
    """Return the words that the workbench's register map gives for a set."""
    written: dict[int, int] = {}

    async def write(at: int, words: Sequence[int]) -> None:
        first = at - FIRST_WINDOW - WINDOW * number
        written.update({first + 4 * place: word for place, word in enumerate(words)})

    async def read(at: int, number_of_words: int) -> list[int]:
        raise AssertionError(f"{number_of_words} words at {at:x} are read to write a set")

    work = RegisterMap(read, write).write_set(number, coefficients, mean)
    with pytest.raises(StopIteration):
        work.send(None)
    return written


def test_every_set_arrives_as_the_register_map_writes_it(running: Firmware) -> None:
    coefficients = file_of(1, 2, 3, 4)
    loaded(running, coefficients)
    assert coefficients.extension is not None
    entries = [coefficients, *coefficients.extension.without]
    for number, entry in enumerate(entries):
        assert entry.extension is not None
        assert entry.extension.mean is not None
        expected = words_by(entry, entry.extension.mean, number)
        found = running.core.window(number)
        assert {at: found.get(at, 0) for at in expected} == expected
    assert running.status("set_without_head") == ["1", "2", "3", "4"]


def test_the_failover_is_on_with_its_causes_while_the_mean_is_active(running: Firmware) -> None:
    names = ("missing_edges", "parity.step_limit", "parity.limit")
    running.send("set failover_parity_counts 9")
    loaded(running, file_of(1, 2, 3, 4))
    every = sum(bit("failover", cause) for cause in CAUSES)
    assert running.core.get("failover") == every | bit("failover", "enable")
    assert [running.core.get(name) for name in names] == [48, 32, 9]
    # The unit is 2^17 clocks of 10 ns; the wait must not be shorter than requested.
    running.send("set failover_return_s 2")
    assert running.core.get("failover") >> 16 == int(np.ceil(2e8 / 2**17))
    running.send("set failover_causes 1")
    assert running.core.get("failover") & 0xFFFF == bit("failover", "enable") | bit(
        "failover", "illegal"
    )
    running.send("set failover_causes 0")
    assert running.core.get("failover") == 0
    assert running.core.get("parity.limit") == 0, (
        "without the failover there is no limit of the parity"
    )
    running.send("forget")
    assert running.status("set_without_head") == []


def test_the_parity_has_the_weights_of_the_workbench() -> None:
    """The parity weights that the firmware computes have the sum 0 and agree with
    ``parity_weights`` within 2 units."""
    places = np.radians([0.0, 64.3, 177.0, 257.9])
    offsets = tuple(int(word) for word in np.rint(places / (2.0 * np.pi) * COUNTS * 16))
    running = Firmware(FailoverCore())
    running.library.application_start(running.application)
    mean = running.application.active.mean
    running.application.active.counts_per_rev = COUNTS
    running.application.has_active = True
    mean.heads, mean.carrier, mean.used = HEADS, 0, 0b1111
    mean.weight[0:HEADS], mean.offset[0:HEADS] = WEIGHTS, offsets
    prepared = running.application.prepared
    prepared.sets = 0b1111
    prepared.sum = running.library.core_prepared_sum(running.core.access, LANES)
    running.library.prepared_arm(running.application)
    found = [running.core.get(f"parity.weight{head}") for head in range(1, HEADS + 1)]
    signed = np.array(found, dtype=np.uint32).view(np.int32)
    assert signed.sum() == 0
    assert np.abs(signed - parity_weights(places)).max() <= 2


def test_a_head_that_is_left_out_is_reported_at_once_and_comes_back_on_request(
    running: Firmware,
) -> None:
    loaded(running, file_of(1, 2, 3, 4))
    running.send("telemetry on")
    running.core.status(left_out=0b0100, active=3, cause=0b001000)
    said = running.step(2)
    assert '"result":"alarm"' in said
    assert '"left_out":[3]' in said
    assert '"alarms":["head_left_out"]' in said
    assert running.status("left_out") == ["3"]
    assert running.status("left_out_causes") == ["8"]
    assert running.step(2) == "", "reported once"
    telemetry = running.turn(turn(3))
    assert (telemetry["left_out"], telemetry["active_set"]) == ([3], 3)
    assert "head_left_out" in telemetry["alarms"]
    running.core.writes.clear()
    assert "no head is left out" in running.send("come_back 2")
    assert running.core.writes == []
    assert running.send("come_back 3").startswith("ok")
    assert running.core.writes == [(address("heads_command"), 1 << 10)]


def test_telemetry_has_the_parity(running: Firmware) -> None:
    loaded(running, file_of(1, 2, 3, 4))
    running.core.set("parity.value", -3 * 2048 - 1024)
    telemetry = running.turn(turn(3))
    assert (telemetry["parity_counts"], telemetry["parity"]) == (-3.5, "within")
    running.core.set(
        "heads_status", running.core.get("heads_status") | bit("heads_status", "parity_beyond")
    )
    assert running.turn(turn(4))["parity"] == "beyond"


def test_while_a_head_is_left_out_its_set_becomes_active_in_place_of_a_swap(
    running: Firmware,
) -> None:
    """The firmware activates the set without the dead head instead of a new mean of all heads,
    which the gateware would refuse to swap in."""
    loaded(running, file_of(1, 2, 3, 4))
    running.core.status(left_out=0b0010, active=2)
    running.core.writes.clear()
    swap = (address("command"), bit("command", "swap"))
    loaded(running, file_of(1, 2, 3))
    assert swap not in running.core.writes
    assert (address("heads_command"), 1 << 7 | 2 << 4) in running.core.writes
    assert running.core.get("heads_status") & 0x7F == 0b0010 | 2 << 4
    assert running.core.get("failover") & 1


def test_a_mean_without_a_set_for_the_left_out_head_is_refused(running: Firmware) -> None:
    loaded(running, file_of(1, 2, 3, 4))
    running.core.status(left_out=0b0010, active=2)
    running.core.writes.clear()
    assert load(running, file_of(1)) == "ok"
    running.turn(turn(2))
    assert state(running) == "load refused head_left_out"
    swap = (address("command"), bit("command", "swap"))
    assert swap not in running.core.writes


def test_the_failover_stays_on_after_words_that_do_not_read_back(running: Firmware) -> None:
    """A refused candidate changes neither the active mean nor its sets; the failover of this mean
    stays on."""
    loaded(running, file_of(1, 2, 3, 4))
    before = running.core.get("failover")
    assert load(running, file_of()) == "ok"
    running.core.broken_lane = 0
    running.turn(turn(3))
    assert state(running) == "load refused not_read_back"
    assert running.core.get("failover") == before
    assert running.status("set_without_head") == ["1", "2", "3", "4"]


def test_a_re_arm_asks_for_every_head(running: Firmware) -> None:
    loaded(running, file_of(1, 2, 3, 4))
    running.core.status(left_out=0b0010, active=2)
    running.core.writes.clear()
    running.send("rearm")
    assert (address("heads_command"), 0b0010 << 8) in running.core.writes
    assert running.core.get("failover") == 0


def test_a_failed_head_without_a_set_is_reported_until_the_failover_is_switched_on_again(
    running: Firmware,
) -> None:
    """The gateware refuses the set without a head if this set is not valid. The head then stays in
    the mean, and only this alarm reports the fault."""
    loaded(running, file_of(1, 2))
    running.send("telemetry on")
    refused = bit("heads_status", "swap_refused")
    running.core.set("heads_status", running.core.get("heads_status") | refused)
    assert '"alarms":["no_set"]' in running.step(2)
    assert running.step(2) == "", "reported once"
    assert "no_set" in running.turn(turn(3))["alarms"]
    # The gateware clears the flag when `failover` is written.
    running.send("set failover_step_counts 40")
    running.core.status(left_out=0, active=7)
    running.step()
    assert running.turn(turn(4))["alarms"] == []


@pytest.mark.parametrize("event", ["rearm", "forget", "stuck"])
@pytest.mark.parametrize("head1_is_left_out", [False, True])
def test_without_a_mean_the_core_follows_head_1(
    running: Firmware, event: str, head1_is_left_out: bool
) -> None:
    """The core captures no turn while its mean uses a head without an index; so the firmware swaps
    to the words of head 1 alone, unless the gateware would refuse them."""
    loaded(running, file_of(1, 2, 3, 4))
    if head1_is_left_out:
        running.core.status(left_out=0b0001, active=1)
    running.core.writes.clear()
    if event == "stuck":
        position = running.core.get("snapshot.head1_position")
        running.core.set("snapshot.head1_position", position + 5 * COUNTS)
        running.step()
        assert "stuck_captures 1" in running.send("status")
    else:
        running.send(event)
    written = dict(running.core.writes)
    words = [written.get(MEAN + 4 * place) for place in range(9)]
    swap = (address("command"), bit("command", "swap"))
    assert (swap in running.core.writes) is not head1_is_left_out
    alone = [0, 0, 0, 0, 65_536, 0, 0, 0, 1 << 4]
    assert words == ([None] * 9 if head1_is_left_out else alone)


def test_the_first_frame_of_a_set_ends_the_failover_of_the_former_ones(running: Firmware) -> None:
    """The first frame of a set switches the failover off before any word of the sets changes; the
    gateware refuses an incomplete set."""
    loaded(running, file_of(1, 2, 3, 4))
    frames = load_frames(file_of(1, 2))
    first = next(place for place, frame in enumerate(frames) if "load without " in frame)
    send(running, frames[:first])
    assert running.core.get("failover") & 1
    running.core.writes.clear()
    assert send(running, frames[first : first + 1]) == ["ok"]
    offsets = [offset for offset, _ in running.core.writes]
    inside = [FIRST_WINDOW <= offset < 2 * FIRST_WINDOW for offset in offsets]
    assert offsets.index(address("failover")) < inside.index(True)
    choices = [running.core.window(number)[0x820] for number in range(1, HEADS + 1)]
    assert choices == [0] * HEADS
    running.send("load abort")
    assert running.status("failover") == ["off"]
    assert running.status("set_without_head") == []


@pytest.mark.parametrize("end", ["aborted", "interrupted", "refused"])
def test_a_load_that_ends_the_failover_for_nothing_raises_an_alarm(
    running: Firmware, end: str
) -> None:
    """The gateware has room for one group of sets, so that the first frame of a new set ends the
    failover of the active mean. Every turn reports this until a load with sets is active."""
    loaded(running, file_of(1, 2, 3, 4))
    assert "failover_off" not in running.turn(turn(3))["alarms"]
    frames = load_frames(file_of(1, 2))
    first, second = (place for place, frame in enumerate(frames) if "load without " in frame)
    assert set(send(running, frames[:second])) == {"ok"}
    if end == "refused":
        assert send(running, [frames[first]]) == ["error: load out_of_range"], "the same head twice"
    if end == "aborted":
        running.send("load abort")
    for seed in (4, 5):
        telemetry = running.turn(turn(seed))
        assert telemetry["mean_of_heads"] == HEADS
        assert telemetry["alarms"] == ["failover_off"]
    assert "alarm failover_off" in running.send("status")
    assert load(running, file_of(1, 2)) == "ok"
    telemetry = running.turn(turn(6))
    running.step(3)
    assert (telemetry["result"], telemetry["alarms"]) == ("applied", [])
    assert running.status("set_without_head") == ["1", "2"]
    assert running.core.get("failover") & 1
    assert running.turn(turn(7))["alarms"] == []


def test_without_former_sets_a_load_raises_no_alarm(running: Firmware) -> None:
    """If the mean had no sets, an aborted load overwrites nothing and raises no alarm."""
    loaded(running, file_of())
    frames = load_frames(file_of(1, 2))
    first = next(place for place, frame in enumerate(frames) if "load without " in frame)
    send(running, frames[: first + 1])
    running.send("load abort")
    assert running.turn(turn(3))["alarms"] == []


@pytest.mark.parametrize("reason", ["out_of_range", "no_failover"])
def test_sets_that_do_not_fit_are_refused(reason: str) -> None:
    """The firmware refuses a set for the failure of head 2 if its mask of used heads still contains
    head 2, and refuses every prepared set if the core has no failover."""
    core = FailoverCore()
    if reason == "no_failover":
        core.set("capability", HEADS | 1 << 3)
    running = Firmware(core)
    running.library.application_start(running.application)
    frames = load_frames(file_of(2))
    if reason == "out_of_range":
        numbers = [2, 2, 0, 0b1111, 2]
        crc = zlib.crc32(struct.pack("<5I", *numbers))
        frame = f"load without {' '.join(map(str, numbers))} {crc:08X}"
        frames = [frame if "load without " in one else one for one in frames]
    answers = [answer for answer in send(running, frames) if answer != "ok"]
    assert answers[0] == f"error: load {reason}"
    written = [at for at, _ in core.writes if FIRST_WINDOW <= at < 2 * FIRST_WINDOW]
    assert reason != "no_failover" or written == [], "the core would refuse the access"
    assert core.window(2).get(0x820, 0) == 0


@pytest.mark.parametrize(("of_table", "of_set"), [(0.7, 0.7), (0.55, 0.55), (0.4, 0.4), (0.7, 0.2)])
@pytest.mark.parametrize("missing", [1, 4])
def test_the_slope_of_a_set_counts_together_with_the_local_table(
    of_table: float, of_set: float, missing: int
) -> None:
    """The local table stays active after a failover, so its slope and that of the set for the
    missing head add up. The corrected angle could turn back if |d error / d reading| were 1 or
    more."""
    core = FailoverCore()
    core.set("capability", core.get("capability") | LOCAL_TABLE)
    running = Firmware(core)
    running.library.application_start(running.application)
    exponent, fraction, period = 6, 4, 128
    step = (COUNTS >> exponent) / POINTS
    place = np.arange(POINTS) % period
    rise = np.minimum(place, period - place) * step * of_table
    table = LocalTable(
        tuple(np.rint(rise * 2**fraction).astype(int).tolist()), (0,), exponent, fraction
    )
    order = 20_000
    amplitude = of_set * COUNTS / (2.0 * np.pi * order)
    lanes = Coefficients.from_harmonics([order], [amplitude], [0.3], COUNTS, LANES)
    sets = [without(head) for head in (1, 4)]
    sets = [
        replace(lanes, extension=one.extension) if head == missing else one
        for head, one in zip((1, 4), sets, strict=True)
    ]
    extension = Extension(mean=MeanSet(WEIGHTS, OFFSETS), without=tuple(sets), local_table=table)
    coefficients = replace(lanes_of(1.0), extension=extension)
    *before, last = send(running, load_frames(coefficients))
    assert set(before) == {"ok"}
    may_be_loaded = of_table + of_set < 0.95
    assert last == ("ok" if may_be_loaded else "error: load too_steep")
    assert (of_limits(coefficients) == []) == may_be_loaded, "the host has the same limit"


def test_a_frame_that_is_left_out_spoils_the_whole(running: Firmware) -> None:
    frames = load_frames(file_of(1, 2))
    short = [frame for frame in frames if not frame.startswith("load without_lane 1 ")]
    assert send(running, short)[-1] != "ok"
    assert state(running) != "load waiting"


def test_words_that_the_gateware_lost_switch_the_failover_off(running: Firmware) -> None:
    loaded(running, file_of(1, 2, 3, 4))
    running.send("telemetry on")
    running.core.words[FIRST_WINDOW + 3 * WINDOW + 0x810] ^= 1
    said = running.send("set failover_step_counts 40") + running.step()
    assert running.core.get("failover") == 0
    assert '"alarms":["coefficients"]' in said
    assert running.status("set_without_head") == []


def test_sets_with_lanes_that_follow_a_condition_stay_on_the_host() -> None:
    coefficients = file_of(1, 2)
    assert heads_without_sets(coefficients) == ()
    assert coefficients.extension is not None
    extension = replace(
        coefficients.extension,
        modulators=((1, "speed"),),
        conditions=Conditions(16, 0, 90.0),
    )
    follows = replace(coefficients, extension=extension)
    assert heads_without_sets(follows) == (1, 2)
    assert not [frame for frame in load_frames(follows) if "without" in frame]
    assert Capability(heads=4, mean=True, failover=True).lacking(coefficients.extension.needs) == []


def test_the_firmware_refuses_sets_with_a_lane_of_a_real_order(running: Firmware) -> None:
    """The firmware refuses sets for a missing head together with a lane of a non-integer order,
    although no tool sends these frames. A lane of a non-integer order needs a turn step, and a
    prepared set in the gateware has none."""
    core = running.core
    core.set("capability", core.get("capability") | 1 << 6)
    frames = load_frames(file_of(1), unseen=True)
    values = [0, 0, 0, 1 << 15, 2048]
    words = struct.pack("<5I", *values)
    frame = f"load real {' '.join(map(str, values))} {zlib.crc32(words):08X}"
    place = next(n for n, line in enumerate(frames) if line.startswith("load mean "))
    numbers = [line.split()[2:-1] for line in (*frames[:place], frame, *frames[place:-1])]
    whole = b"".join(
        struct.pack(f"<{len(row)}I", *(int(word) & 0xFFFF_FFFF for word in row)) for row in numbers
    )
    *before, last = send(
        running,
        [*frames[:place], frame, *frames[place:-1], f"load end {zlib.crc32(whole):08X}"],
    )
    assert set(before) == {"ok"}
    assert last.startswith("error: load out_of_range")
