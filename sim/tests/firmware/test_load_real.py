"""Tests that lanes of non-integer orders, loaded over the console, have amplitude 0 until their
phase is known."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from sim.tests.calibration.synthetic import COUNTS
from sim.tests.firmware.model_core import COEFFICIENTS, Firmware, address
from sim.tests.firmware.test_load import SUBDIVISION, file_of, running, send, state, turn

from arctrue.device.load import load_frames, phase_commands
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.lane_words import phase_step, turn_step
from arctrue.gateware.register_access import coefficient_words
from arctrue.gateware.turn_offset_sweep import turn_offsets

__all__ = ["running"]

LANES = 32
ORDERS = (0.5, 71.4)
REAL_LANES = (LANES - 2, LANES - 1)
REAL_ORDERS = 1 << 6


def with_real_orders(plain: dict[int, tuple[float, float]]) -> Coefficients:
    """Return coefficients with the orders of ``plain``; the last two lanes have the orders of a
    belt and a gear."""
    bank = file_of(plain)
    lines = Coefficients.from_harmonics([0, 0], [30.0, 12.0], [0.7, -2.0], COUNTS, 2)
    amplitudes, offsets = bank.amplitudes.copy(), bank.phase_offsets.copy()
    amplitudes[-2:], offsets[-2:] = lines.amplitudes, lines.phase_offsets
    bank = dataclasses.replace(bank, amplitudes=amplitudes, phase_offsets=offsets)
    return bank.with_real_orders(dict(zip(REAL_LANES, ORDERS, strict=True)))


def built(running: Firmware) -> None:
    running.core.set("version", 0x000800)
    running.core.set("capability", REAL_ORDERS | 2)


def lane_words(bank: dict[int, int], lane: int) -> list[int]:
    return [bank[COEFFICIENTS + 16 * lane + 4 * word] for word in range(4)]


def turn_step_at(running: Firmware, lane: int) -> int:
    first = address("turn_number") - 0x200 + 8 * lane
    low, high = (running.core.words[first + 4 * word] for word in range(2))
    return low | high << 32


def load_all(running: Firmware, wanted: Coefficients) -> None:
    built(running)
    assert set(send(running, load_frames(wanted, unseen=True))) == {"ok"}
    for seed in (5, 6, 7):
        running.turn(turn(seed))
        if state(running) == "load active":
            return
    raise AssertionError(state(running))


def status(running: Firmware) -> list[str]:
    lines = running.send("load status").splitlines()
    return [line for line in lines if line.startswith(("real_order", "turn_number"))]


def test_they_are_off_until_the_operator_gives_their_phase(running: Firmware) -> None:
    wanted = with_real_orders(SUBDIVISION)
    load_all(running, wanted)
    running.core.set("turn_number", 0xFFFF_FFFD)
    assert status(running) == [
        "real_order 0.500000000 phase_unknown",
        "real_order 71.400000000 phase_unknown",
        "turn_number -3",
    ]
    for lane, order in zip(REAL_LANES, ORDERS, strict=True):
        assert lane_words(running.core.active, lane)[3] == 0
        assert turn_step_at(running, lane) == turn_step(order)
    assert turn_step_at(running, 0) == 0
    # The core's turn -3 is turn 0 of the file.
    for line in phase_commands(wanted, -3):
        assert running.send(line).strip() == "ok"
    running.send("telemetry on")
    assert "alarms" not in running.step(5), "a requested swap raises no alarm"
    expected = coefficient_words(wanted.from_turn(-3))
    for lane, order in zip(REAL_LANES, ORDERS, strict=True):
        words = lane_words(running.core.active, lane)
        step = words[0] | words[1] << 32
        assert abs(step - phase_step(order, COUNTS)) <= 1
        assert words[3] == expected[4 * lane + 3]
        # The command gives degrees with six decimals, and the firmware rounds the offset twice:
        # 2⁻²³ turn.
        assert abs(words[2] - expected[4 * lane + 2]) <= 2
        # In turn -3 of the core the phase equals that of the file.
        there = turn_offsets(-3, [turn_step(order)], [words[2]])
        assert abs(int(there[0]) - int(wanted.phase_offsets[lane])) <= 2
    assert status(running)[0] == "real_order 0.500000000 phase_known"
    # The calibration continues with the other lanes.
    before = lane_words(running.core.active, LANES - 1)
    running.turn(turn(9))
    assert lane_words(running.core.active, LANES - 1) == before


def test_a_set_without_them_takes_them_away(running: Firmware) -> None:
    load_all(running, with_real_orders(SUBDIVISION))
    assert set(send(running, load_frames(file_of(SUBDIVISION)))) == {"ok"}
    running.turn(turn(8))
    assert state(running) == "load active"
    assert lane_words(running.core.active, LANES - 1)[3] == 0
    assert turn_step_at(running, LANES - 1) == 0
    assert running.send("load phase 0 10 0").startswith("error: no lane of a real order")


@pytest.mark.parametrize(
    ("has_generic", "unseen", "reason"),
    [(False, True, "no_real_orders"), (True, False, "unseen_order")],
)
def test_what_cannot_be_is_refused(
    running: Firmware, has_generic: bool, unseen: bool, reason: str
) -> None:
    if has_generic:
        built(running)
    *before, last = send(running, load_frames(with_real_orders({}), unseen=unseen))
    assert set(before) == {"ok"}
    assert last.startswith(f"error: load {reason}")


def test_a_steep_line_is_refused(running: Firmware) -> None:
    """The firmware refuses a harmonic of order 5,000.5 that is so large that the corrected angle
    would move backwards."""
    built(running)
    wanted = with_real_orders({})
    amplitudes = wanted.amplitudes.copy()
    amplitudes[-1] = 8000 * 2048
    steep = dataclasses.replace(wanted, amplitudes=amplitudes)
    steep = steep.with_real_orders({LANES - 1: 5000.5})
    *_, last = send(running, load_frames(steep, unseen=True))
    assert last.startswith("error: load too_steep")


@pytest.mark.parametrize("words", ["0 400 0", "0 x 0", "0 10 1.5", "x 10 0"])
def test_a_phase_that_is_none_is_refused(running: Firmware, words: str) -> None:
    load_all(running, with_real_orders(SUBDIVISION))
    assert running.send(f"load phase {words}").startswith("error: ")
    assert status(running)[0].endswith("phase_unknown")


def test_in_every_turn_of_the_core_the_phase_is_the_equations(running: Firmware) -> None:
    """In the turn of the core for which a phase is given, the lane has this phase. The firmware
    computes modulo 2⁴⁸; the test compares it with the model for positive and negative turn numbers,
    and compares the phase step per count with the exact quotient."""
    from sim.tests.firmware.library import firmware

    ffi, library = firmware()
    rng = np.random.default_rng(3)
    for turn_number in (0, 1, -1, 2**23 - 1, -(2**23), *rng.integers(-(2**23), 2**23, 20).tolist()):
        step, phase = int(rng.integers(1, 2**48)), int(rng.integers(0, 2**24))
        lane = ffi.new("struct real_lane *", {"order": 3, "turn_step": step})
        library.real_lane_set_phase(lane, phase, turn_number)
        assert int(turn_offsets(turn_number, [step], [lane.phase_offset])[0]) == phase
        counts = int(rng.integers(4, 2**24))
        exact = round((3 * 2**48 + step) / counts) % 2**48
        found = library.real_lane_phase_step(lane, counts)
        assert abs(found - exact) <= max(1, exact >> 50)
