"""Tests that the firmware loads a file of coefficients from the console completely or not at all,
and that the calibration continues with the loaded file."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sim.tests.calibration.synthetic import COUNTS, Disc
from sim.tests.firmware.library import firmware as c_library
from sim.tests.firmware.model_core import Firmware, ModelCore
from sim.tests.firmware.test_application import (
    ARCSEC_PER_COUNT,
    SAMPLES,
    active_coefficients,
    controls,
)
from sim.tests.firmware.test_estimates import counts_of

from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.lane_words import phase_step

HIGH = 4096
"""Order that is higher than the orders of the calibration; one period of it has 4,096 counts."""
DISC = Disc({1: (150.0, 0.4), 2: (6.0, 4.2), 7: (1.2, 2.9)})
SUBDIVISION_ARCSEC, SUBDIVISION_RAD = 0.5, 1.3
READINGS = np.arange(0, COUNTS, COUNTS // 65_536 - 1)
LEFT_ARCSEC = 0.05
"""Largest error of the corrected reading after the calibration, from noise of 0.1″ over 1,500
samples with gains below 2."""


def turn(seed: int = 1, noise: float = 0.1, disc: Disc = DISC) -> Any:
    """Return a turn in which head 1 also has a subdivision error, which is a function of head 1's
    reading."""
    counts = counts_of(disc, noise, seed, samples=SAMPLES)
    phase = HIGH * counts[0] * (2.0 * np.pi / COUNTS) + SUBDIVISION_RAD
    error = SUBDIVISION_ARCSEC * np.cos(phase) / ARCSEC_PER_COUNT
    counts[0] += np.rint(error).astype(np.int64)
    return counts


def file_of(lanes: dict[int, tuple[float, float]], counts_per_rev: int = COUNTS) -> Coefficients:
    """Return coefficients from {order: (amplitude ″, phase rad)}."""
    amplitudes = np.array([a for a, _ in lanes.values()]) * counts_per_rev / 1_296_000
    return Coefficients.from_harmonics(
        list(lanes), amplitudes, [p for _, p in lanes.values()], counts_per_rev, 32
    )


SUBDIVISION = {HIGH: (SUBDIVISION_ARCSEC, SUBDIVISION_RAD)}


@pytest.fixture
def running() -> Firmware:
    made = Firmware(ModelCore())
    made.library.application_start(made.application)
    made.core.see_index()
    made.send("set orders 8")
    made.step()
    for seed in range(1, 5):
        made.turn(turn(seed))
    assert controls(made.core)["compensate"]
    return made


def send(running: Firmware, frames: list[str]) -> list[str]:
    return [running.send(frame).strip() for frame in frames]


def load(running: Firmware, coefficients: Coefficients) -> str:
    """Send coefficients, check that all frames except the last are accepted, and return the answer
    to the last one."""
    *before, last = send(running, load_frames(coefficients))
    assert set(before) == {"ok"}
    return last


def state(running: Firmware) -> str:
    return running.send("load status").splitlines()[0]


def left(running: Firmware, disc: Disc = DISC, subdivision: float = SUBDIVISION_ARCSEC) -> float:
    """Return the largest error of the corrected reading in arcseconds."""
    angle = READINGS * (2.0 * np.pi / COUNTS)
    wrong = np.rad2deg(angle - disc.true_angle(angle)) * 3600.0
    wrong += subdivision * np.cos(HIGH * angle + SUBDIVISION_RAD)
    applied = active_coefficients(running.core).error_counts(READINGS) * ARCSEC_PER_COUNT
    return float(np.abs(wrong - applied).max())


def test_what_is_loaded_is_active_during_the_calibration(running: Firmware) -> None:
    assert left(running) > SUBDIVISION_ARCSEC
    assert load(running, file_of(SUBDIVISION)) == "ok"
    assert state(running) == "load waiting"
    assert left(running) > SUBDIVISION_ARCSEC, "no turn has judged it yet"
    assert running.turn(turn(seed=5))["result"] == "applied"
    assert state(running) == "load active"
    assert f"loaded_order {HIGH}\r\n" in running.send("load status")
    assert left(running) < LEFT_ARCSEC
    # The calibration continues with the other orders and leaves the loaded order unchanged.
    moved = Disc({**DISC.orders, 1: (155.0, 0.4)})
    for seed in range(6, 30):
        running.turn(turn(seed, disc=moved))
    assert left(running, moved) < 2 * LEFT_ARCSEC


def test_an_order_that_is_loaded_is_no_longer_the_calibrations(running: Firmware) -> None:
    """The disc's order 2 changes, but the firmware keeps the loaded value until another file is
    loaded."""
    load(running, file_of({2: (6.0, 4.2)}))
    running.turn(turn(seed=5))
    assert state(running) == "load active"
    moved = Disc({**DISC.orders, 2: (9.0, 4.2)})
    for seed in range(6, 26):
        telemetry = running.turn(turn(seed, disc=moved))
    assert telemetry["reason"] in ("none", "not_better")
    rows = [line.split() for line in running.send("show harmonics").splitlines()[1:-1]]
    assert rows[1][-1] == "loaded"
    bank = active_coefficients(running.core)
    (lane,) = np.flatnonzero(bank.phase_steps == phase_step(2, COUNTS))
    assert bank.amplitudes[lane] == pytest.approx(6.0 / ARCSEC_PER_COUNT * 2048, abs=1.0)
    # When a file without this order is loaded, the order belongs to the calibration again.
    assert load(running, file_of({})) == "ok"
    for seed in range(30, 34):
        running.turn(turn(seed, disc=moved))
    assert state(running) == "load none"
    assert left(running, moved) < SUBDIVISION_ARCSEC + 3 * LEFT_ARCSEC


def test_every_order_has_one_lane(running: Firmware) -> None:
    load(running, file_of({1: (150.0, 0.4), 2: (6.0, 4.2), **SUBDIVISION}))
    for seed in range(5, 12):
        running.turn(turn(seed, disc=Disc({**DISC.orders, 7: (0.2 * seed, 2.9)})))
    assert state(running) == "load active"
    bank = active_coefficients(running.core)
    steps = bank.phase_steps[bank.amplitudes != 0]
    assert len(set(steps.tolist())) == len(steps)
    assert phase_step(7, COUNTS) in steps.tolist()


@pytest.mark.parametrize(
    "wrong",
    [
        {HIGH: (SUBDIVISION_ARCSEC, SUBDIVISION_RAD + np.pi)},
        {HIGH: (SUBDIVISION_ARCSEC, SUBDIVISION_RAD + 1.6)},
        {1: (150.0, 0.5)},
        {3: (2.0, 1.0)},
    ],
    ids=["opposite", "phase", "order 1", "not there"],
)
def test_what_the_turn_speaks_against_is_refused(
    running: Firmware, wrong: dict[int, tuple[float, float]]
) -> None:
    before = dict(running.core.active)
    running.send("freeze on")
    assert load(running, file_of(wrong)) == "ok"
    running.turn(turn(seed=5))
    assert state(running) == "load refused worse_prediction"
    assert running.core.active == before


def test_frozen_coefficients_take_an_order_to_load(running: Firmware) -> None:
    running.send("freeze on")
    load(running, file_of(SUBDIVISION))
    running.turn(turn(seed=5))
    assert left(running) < LEFT_ARCSEC


def test_it_waits_for_a_turn_that_can_be_used(running: Firmware) -> None:
    load(running, file_of(SUBDIVISION))
    bad = turn(seed=5)
    bad[0, 500:] += 50_000
    assert running.turn(bad)["reason"] == "jump"
    assert state(running) == "load waiting"
    running.turn(turn(seed=6))
    assert state(running) == "load active"


@pytest.mark.parametrize(
    ("lanes", "counts_per_rev", "reason"),
    [
        (SUBDIVISION, 3_600_000, "another_table"),
        # The slope 2π·65535·6.5″/1296000″ is larger than 1.
        ({65_535: (6.5, 0.0)}, COUNTS, "too_steep"),
    ],
)
def test_sets_that_no_turn_needs_to_judge(
    running: Firmware, lanes: dict[int, tuple[float, float]], counts_per_rev: int, reason: str
) -> None:
    assert load(running, file_of(lanes, counts_per_rev)) == f"error: load {reason}"
    assert state(running) == f"load refused {reason}"
    running.turn(turn(seed=5))
    assert "loaded_order" not in running.send("load status")


def test_more_lanes_than_there_are() -> None:
    made = Firmware(ModelCore(lanes=4))
    made.library.application_start(made.application)
    frames = load_frames(file_of(dict.fromkeys(range(1, 6), (1.0, 0.0))))
    assert send(made, frames)[0] == "error: load too_many_lanes"


def test_frames_out_of_their_place(running: Firmware) -> None:
    begin, first, second, end = load_frames(file_of({1: (150.0, 0.4), 2: (6.0, 4.2)}))
    assert running.send(first).strip() == "error: load wrong_frame"
    assert send(running, [begin, second]) == ["ok", "error: load wrong_frame"]
    assert send(running, [first, first]) == ["ok", "error: load wrong_frame"]
    assert send(running, [end]) == ["error: load wrong_crc"]
    assert send(running, [begin, first, second, end]) == ["ok"] * 4
    assert running.send("load abort").strip() == "ok"
    assert state(running) == "load none"
    assert running.send("load lane 1 2 3").startswith("error: use: load status")


def frame(name: str, *values: int) -> str:
    words = b"".join((value & 0xFFFF_FFFF).to_bytes(4, "little") for value in values)
    return f"load {name} {' '.join(map(str, values))} {zlib.crc32(words):x}"


@pytest.mark.parametrize(
    ("lane", "reason"),
    [
        ((0, 0, 0, 1), "out_of_range"),
        ((0, 65_536, 0, 1), "out_of_range"),
        ((0, 1, 1 << 24, 1), "out_of_range"),
        ((0, 1, 0, 1 << 24), "out_of_range"),
        ((0, 1, 0, -(1 << 24) - 1), "out_of_range"),
        ((0, 7, 0, 1), "order_twice"),
    ],
)
def test_what_no_lane_holds(running: Firmware, lane: tuple[int, ...], reason: str) -> None:
    """The firmware refuses words that no lane can hold, and an order that comes twice. The frames
    have a right CRC, so that only the sending program can have made the error."""
    sent = [frame("begin", 2, COUNTS)]
    if reason == "order_twice":
        sent += [frame("lane", 0, 7, 0, 1)]
        lane = (1, *lane[1:])
    assert send(running, sent)[-1] == "ok"
    assert running.send(frame("lane", *lane)).strip() == f"error: load {reason}"
    assert state(running) == f"load refused {reason}"


def test_a_set_that_is_not_whole(running: Firmware) -> None:
    words = b"".join(value.to_bytes(4, "little") for value in (2, COUNTS, 0, 7, 0, 1))
    sent = [frame("begin", 2, COUNTS), frame("lane", 0, 7, 0, 1)]
    assert send(running, sent) == ["ok", "ok"]
    assert running.send(f"load end {zlib.crc32(words):X}").strip() == "error: load not_whole"


@given(st.data())
@settings(max_examples=150, deadline=None)
def test_a_changed_character_is_noticed(data: Any) -> None:
    """If any single character of a frame changes, the firmware accepts no set that differs from the
    sent one."""
    made = Firmware(ModelCore())
    made.library.application_start(made.application)
    frames = load_frames(file_of({1: (150.0, 0.4), HIGH: (0.5, 1.0)}))
    number = data.draw(st.integers(0, len(frames) - 1))
    frame = frames[number]
    place = data.draw(st.integers(0, len(frame) - 1))
    other = data.draw(st.characters(min_codepoint=32, max_codepoint=126))
    frames[number] = frame[:place] + other + frame[place + 1 :]
    answers = send(made, frames)
    if answers == ["ok"] * len(frames):
        received = made.application.load.received
        lanes = [received.lane[i] for i in range(2)]
        assert [lane.order for lane in lanes] == [1, HIGH]
        expected = file_of({1: (150.0, 0.4), HIGH: (0.5, 1.0)})
        assert [lane.phase_offset for lane in lanes] == expected.phase_offsets[:2].tolist()
        assert [lane.amplitude for lane in lanes] == expected.amplitudes[:2].tolist()


def test_a_re_arm_keeps_what_is_loaded_and_has_it_judged(running: Firmware) -> None:
    load(running, file_of(SUBDIVISION))
    running.turn(turn(seed=5))
    running.send("rearm")
    running.core.see_index()
    running.step()
    assert state(running) == "load waiting"
    for seed in range(6, 10):
        running.turn(turn(seed))
    assert state(running) == "load active"
    assert left(running) < LEFT_ARCSEC
    running.send("forget")
    assert state(running) == "load none"
    assert not controls(running.core)["compensate"]


def test_a_bank_that_does_not_hold_it(running: Firmware) -> None:
    load(running, file_of(SUBDIVISION))
    running.core.broken_lane = 0
    telemetry = running.turn(turn(seed=5))
    assert telemetry["alarms"] == ["coefficients"]
    assert state(running) == "load refused not_read_back"


def test_every_reason_is_explained(running: Firmware) -> None:
    ffi, library = c_library()
    for answer in range(1, library.LOAD_ANSWERS):
        name = ffi.string(library.load_answer_name(answer)).decode()
        lines = running.send(f"help {name}").splitlines()
        assert lines[-1] == "ok", name
        assert len(lines[0].split()) >= 5, "a sentence"


@given(st.integers(1, 65_535), st.integers(4, 2**24))
@settings(max_examples=200, deadline=None)
def test_phase_steps(order: int, counts_per_rev: int) -> None:
    """Compare the C code's phase step with the exact quotient in Python integers of any size. Half
    a step may be rounded up or down."""
    step = c_library()[1].coefficients_phase_step(order, counts_per_rev)
    exact = order * 2**48
    apart = (step * counts_per_rev - exact) % (counts_per_rev * 2**48)
    apart = min(apart, counts_per_rev * 2**48 - apart)
    assert 2 * apart <= counts_per_rev
