"""Tests of lanes whose amplitude follows a condition (the direction or the speed of the table, or a
word from the console), from the console to the registers."""

from __future__ import annotations

import cmath
import dataclasses
import zlib
from typing import Any

import numpy as np
import pytest
from sim.tests.calibration.synthetic import COUNTS, Disc
from sim.tests.firmware.model_core import COEFFICIENTS, Firmware, address
from sim.tests.firmware.test_application import SAMPLES
from sim.tests.firmware.test_estimates import counts_of
from sim.tests.firmware.test_load import DISC, SUBDIVISION, file_of, running, send, state, turn

from arctrue.calibration.acceptance import of_speed_feedback
from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import Conditions
from arctrue.gateware.register_access import coefficient_words

__all__ = ["running"]

LANES = 32
HALF_REVERSAL_COUNTS = 26.0
CONDITIONS = Conditions(16 * 700, 4, 45.0)


def with_direction(
    plain: dict[int, tuple[float, float]], conditions: Conditions = CONDITIONS
) -> Coefficients:
    """Return coefficients with the orders of ``plain``; the last lane has order 0 × direction."""
    bank = file_of(plain)
    last = Coefficients.from_harmonics([0], [HALF_REVERSAL_COUNTS], [np.pi], COUNTS, 1)
    amplitudes, offsets = bank.amplitudes.copy(), bank.phase_offsets.copy()
    amplitudes[-1], offsets[-1] = last.amplitudes[0], last.phase_offsets[0]
    return dataclasses.replace(
        bank,
        amplitudes=amplitudes,
        phase_offsets=offsets,
        extension=Extension(conditions=conditions, modulators=((LANES - 1, "direction"),)),
    )


def modulators(running: Firmware) -> None:
    running.core.set("version", 0x000800)
    running.core.set("capability", 1 << 5 | 2)


def last_lane(bank: dict[int, int]) -> list[int]:
    first = COEFFICIENTS + 16 * (LANES - 1)
    return [bank[first + 4 * word] for word in range(4)]


def test_they_come_to_the_last_lanes_after_the_others(running: Firmware) -> None:
    """The words of the lane and of the condition window equal those of the file; the calibration
    keeps these words."""
    modulators(running)
    wanted = with_direction(SUBDIVISION)
    assert set(send(running, load_frames(wanted, force=True))) == {"ok"}
    assert state(running) == "load waiting"
    running.turn(turn(5))
    assert state(running) == "load active"
    expected = coefficient_words(wanted)[-4:]
    assert last_lane(running.core.active) == expected
    assert expected[1] == 1 << 16
    assert running.core.get("conditions.width") == CONDITIONS.width
    assert running.core.get("conditions.dead_zone") == 4
    nominal = running.core.get("conditions.nominal_speed") / 2**32
    assert nominal == pytest.approx(45.0 / 360.0 * COUNTS / 1e8, abs=2.0**-32)
    # In the next turns the calibration keeps these words and all orders of its own.
    for seed in (6, 7):
        running.turn(turn(seed))
        assert last_lane(running.core.active) == expected
    # A set without lanes that follow a condition removes these lanes from the core.
    assert set(send(running, load_frames(file_of(SUBDIVISION)))) == {"ok"}
    running.turn(turn(8))
    assert last_lane(running.core.active)[1] == 0
    assert last_lane(running.core.active)[3] == 0


def test_alone_they_are_a_set_and_a_start_asks_again(running: Firmware) -> None:
    modulators(running)
    wanted = with_direction({})
    assert set(send(running, load_frames(wanted, force=True))) == {"ok"}
    running.turn(turn(5))
    assert state(running) == "load active"
    assert last_lane(running.core.active) == coefficient_words(wanted)[-4:]


@pytest.mark.parametrize(
    ("conditions", "force", "built", "reason"),
    [
        (CONDITIONS, True, False, "no_modulators"),
        (CONDITIONS, False, True, "unseen_order"),
        (Conditions(16 * 50, 4, 45.0), True, True, "too_steep"),
    ],
)
def test_what_cannot_be_is_refused(
    running: Firmware, conditions: Conditions, force: bool, built: bool, reason: str
) -> None:
    """The firmware refuses a file in three cases: the core lacks the generic MODULATORS, the frame
    ``load force`` is missing, or the correction changes by 26 counts within 50 counts of travel."""
    if built:
        modulators(running)
    frames = load_frames(with_direction(SUBDIVISION, conditions), force=force)
    *before, last = send(running, frames)
    assert set(before) == {"ok"}
    assert last.startswith(f"error: load {reason}")


@pytest.mark.parametrize(
    ("nominal_deg_per_s", "by_speed", "by_square", "is_taken"),
    [
        (45.0, 0.999, 0.0, True),
        (45.0, 1.001, 0.0, False),
        (45.0, 0.5, 0.2495, True),
        (45.0, 0.5, 0.2505, False),
        (45.0, -1.001, 0.0, False),
        # If the table needs more than 2^14 clocks for a period of four counts, the window lasts
        # this period.
        (0.05, 0.999, 0.0, True),
        (0.05, 1.001, 0.0, False),
    ],
)
def test_lanes_of_the_speed_that_would_swing_are_refused(
    running: Firmware, nominal_deg_per_s: float, by_speed: float, by_square: float, is_taken: bool
) -> None:
    """The firmware and the host accept the same lanes of any order: those that move the corrected
    angle by at most 3/8 of the travel in a window at the nominal speed, or half as much for the
    squared speed."""
    modulators(running)
    bank = file_of(SUBDIVISION)
    most = 0.375 * max(nominal_deg_per_s / 360.0 * COUNTS / 1e8 * 2**14, 4.0)
    lanes = Coefficients.from_harmonics(
        [0, 3], [abs(by_speed) * most, by_square * most], [np.pi * (by_speed < 0), 0.4], COUNTS, 2
    )
    steps, offsets, sizes = (
        bank.phase_steps.copy(),
        bank.phase_offsets.copy(),
        bank.amplitudes.copy(),
    )
    steps[-2:], offsets[-2:] = lanes.phase_steps, lanes.phase_offsets
    sizes[-2:] = lanes.amplitudes
    wanted = dataclasses.replace(
        bank,
        phase_steps=steps,
        phase_offsets=offsets,
        amplitudes=sizes,
        extension=Extension(
            conditions=Conditions(16 * 700, 4, nominal_deg_per_s),
            modulators=((LANES - 2, "speed"), (LANES - 1, "speed_squared")),
        ),
    )
    *before, last = send(running, load_frames(wanted, force=True))
    assert set(before) == {"ok"}
    assert (last.strip() == "ok") == is_taken
    if not is_taken:
        assert last.startswith("error: load unstable_speed")
    assert (of_speed_feedback(wanted) == []) == is_taken


@pytest.mark.parametrize("word", ["width", "dead_zone", "nominal_speed"])
def test_conditions_that_do_not_read_back_are_not_used(running: Firmware, word: str) -> None:
    """A bit that the gateware does not hold ends the load before the swap."""
    modulators(running)
    running.core.broken_word = address(f"conditions.{word}")
    assert set(send(running, load_frames(with_direction(SUBDIVISION), force=True))) == {"ok"}
    running.turn(turn(5))
    assert state(running) == "load refused not_read_back"
    assert last_lane(running.core.active)[1] == 0, "no lane follows the direction"


def test_a_spoiled_frame_and_a_wrong_modulator_are_refused(running: Firmware) -> None:
    modulators(running)
    frames = load_frames(with_direction(SUBDIVISION), force=True)
    place = next(n for n, frame in enumerate(frames) if frame.startswith("load followed"))
    assert set(send(running, frames[:place])) == {"ok"}
    spoiled = frames[place].replace("load followed 0 1", "load followed 0 2")
    assert "wrong_crc" in running.send(spoiled)
    assert running.send(frames[place]).strip() == "ok"
    assert "wrong_frame" in running.send(frames[place])
    assert address("conditions.width") not in dict(running.core.writes)


LOOSE = {1: (20.0, 1.1)}
"""Amplitude (″) and phase (rad) of the part of order 1 that changes sign with the direction; the
disc's own order 1 is added to it."""


def loose_turn(seed: int, direction: int) -> Any:
    """Return the samples of a turn in one direction, as counts of both heads."""
    own = cmath.rect(*DISC.orders[1])
    amplitude, phase = cmath.polar(own + direction * cmath.rect(*LOOSE[1]))
    disc = Disc({**DISC.orders, 1: (amplitude, phase)})
    return counts_of(disc, 0.1, seed, samples=SAMPLES, direction=direction)


def loose_file(loose: tuple[float, float] = LOOSE[1]) -> Coefficients:
    """Return coefficients with the disc's own order 1 in a plain lane, and order 1 × direction in
    the last lane.

    The coefficients treat the orders of the angle as orders of the reading. This is right to 0.1″,
    because 150″ turn the phase of order 1 by 0.04°.
    """
    bank = file_of({1: DISC.orders[1]})
    size, phase = loose
    last = Coefficients.from_harmonics([1], [size * COUNTS / 1_296_000], [phase], COUNTS, 1)
    arrays = {
        name: np.append(getattr(bank, name)[:-1], getattr(last, name))
        for name in ("phase_steps", "phase_offsets", "amplitudes")
    }
    extension = Extension(conditions=CONDITIONS, modulators=((LANES - 1, "direction"),))
    return dataclasses.replace(bank, **arrays, extension=extension)


def test_a_wave_by_direction_waits_for_a_turn_in_the_other_direction(running: Firmware) -> None:
    """A set with order 1 × direction waits for a backward turn: without force a forward turn
    confirms nothing. After a backward turn the set is active and stays right."""
    modulators(running)
    assert set(send(running, load_frames(loose_file(), force=False))) == {"ok"}
    for seed in (5, 6):
        running.turn(loose_turn(seed, 1))
        assert state(running) == "load waiting"
        assert "waits_for the_other_direction" in running.send("load status")
    running.turn(loose_turn(7, -1))
    assert state(running) == "load active"
    # The firmware monitors the loaded orders with the direction of each turn. A loaded order that
    # is wrong in WATCH_TURNS = 3 turns (loaded_watch.h) raises the alarm "error".
    for seed, direction in ((8, 1), (9, -1), (10, 1)):
        telemetry = running.turn(loose_turn(seed, direction))
        assert telemetry["alarms"] == []
        assert state(running) == "load active"


def test_a_wave_of_another_size_is_refused_by_the_turn_down(running: Firmware) -> None:
    """The backward turn refuses a wrong amplitude of order 1 × direction. In a forward turn the sum
    of this lane and the disc's own order is right; in a backward turn the sum is wrong."""
    modulators(running)
    own = cmath.rect(*DISC.orders[1])
    loose = cmath.rect(*LOOSE[1])
    amplitude, phase = cmath.polar(own + 0.5 * loose)
    wrong = loose_file((0.5 * LOOSE[1][0], LOOSE[1][1]))
    plain = file_of({1: (amplitude, phase)})
    bank = dataclasses.replace(
        wrong,
        amplitudes=np.append(plain.amplitudes[:-1], wrong.amplitudes[-1:]),
        phase_offsets=np.append(plain.phase_offsets[:-1], wrong.phase_offsets[-1:]),
    )
    assert set(send(running, load_frames(bank, force=False))) == {"ok"}
    running.turn(loose_turn(5, 1))
    assert state(running) == "load waiting"
    running.turn(loose_turn(6, -1))
    assert state(running).startswith("load refused worse_prediction")


def with_order_0(file: Coefficients) -> Coefficients:
    """Return ``file`` with order 0 × direction in the lane before the last."""
    zero = Coefficients.from_harmonics([0], [HALF_REVERSAL_COUNTS], [np.pi], COUNTS, 1)
    arrays = {
        name: getattr(file, name).copy() for name in ("phase_steps", "phase_offsets", "amplitudes")
    }
    for name, values in arrays.items():
        values[-2] = getattr(zero, name)[0]
    extension = Extension(
        conditions=CONDITIONS, modulators=((LANES - 2, "direction"), (LANES - 1, "direction"))
    )
    return dataclasses.replace(file, **arrays, extension=extension)


def test_the_unseen_scope_takes_order_0_and_turns_still_judge_the_rest(running: Firmware) -> None:
    """With the scope "unseen" the file may contain order 0 × direction, which no turn shows, but
    order 1 × direction still waits for the backward turn. With full force the first turn accepts
    both."""
    modulators(running)
    frames = load_frames(with_order_0(loose_file()))
    assert send(running, frames)[-1].startswith("error: load unseen_order")
    frames = load_frames(with_order_0(loose_file()), unseen=True)
    assert set(send(running, frames)) == {"ok"}
    running.turn(loose_turn(5, 1))
    assert state(running) == "load waiting"
    assert "waits_for the_other_direction" in running.send("load status")
    running.turn(loose_turn(6, -1))
    assert state(running) == "load active"
    assert set(send(running, load_frames(with_order_0(loose_file()), force=True))) == {"ok"}
    running.turn(loose_turn(7, 1))
    assert state(running) == "load active"


def test_the_unseen_scope_takes_no_wrong_wave(running: Firmware) -> None:
    modulators(running)
    wrong = with_order_0(loose_file((LOOSE[1][0], LOOSE[1][1] + 1.0)))
    assert set(send(running, load_frames(wrong, unseen=True))) == {"ok"}
    running.turn(loose_turn(5, 1))
    running.turn(loose_turn(6, -1))
    assert state(running).startswith("load refused worse_prediction")


def test_an_unknown_scope_is_refused(running: Firmware) -> None:
    modulators(running)
    frames = load_frames(loose_file(), force=True)
    place = next(n for n, frame in enumerate(frames) if frame.startswith("load force"))
    assert set(send(running, frames[:place])) == {"ok"}
    wrong = f"load force 3 {zlib.crc32((3).to_bytes(4, 'little')):08X}"
    assert running.send(wrong).startswith("error: load out_of_range")


def test_telemetry_says_what_a_turn_measures_of_each_lane(running: Firmware) -> None:
    """Telemetry reports an amplitude of 20″ for order 1 × direction in a turn of either direction,
    whatever amplitude the file states.

    The bound has two parts: order 1 of the reading and of the angle differ by 0.1″, and the noise
    adds 4 · 0.02″. Before the set is active, order 1 changes by 2·20″ from turn to turn, and the
    calibration takes this for a change within the turn. The standard uncertainty is then 40″/4π,
    divided by √2 for a component.
    """
    by_change = 2.0 * LOOSE[1][0] / (4.0 * np.pi) / np.sqrt(2.0)
    modulators(running)
    size = 18.0
    assert set(send(running, load_frames(loose_file((size, LOOSE[1][1]))))) == {"ok"}
    for seed, direction in ((5, 1), (6, -1)):
        telemetry = running.turn(loose_turn(seed, direction))
        ((order, name, measured, u, loaded),) = telemetry["followed"]
        assert (order, name) == (1, "direction")
        assert loaded == pytest.approx(size, abs=0.01)
        assert 0.0 < u < by_change + 0.2
        assert abs(measured - LOOSE[1][0]) < 0.2, (measured, u)
    # In every further turn telemetry reports the amplitude of the active set in this way.
    assert set(send(running, load_frames(loose_file()))) == {"ok"}
    for seed, direction in ((7, 1), (8, -1)):
        running.turn(loose_turn(seed, direction))
    assert state(running) == "load active"
    telemetry = running.turn(loose_turn(9, 1))
    ((_, _, measured, u, loaded),) = telemetry["followed"]
    assert loaded == pytest.approx(LOOSE[1][0], abs=0.01)
    assert 0.0 < u < 0.2
    assert abs(measured - loaded) < 0.2


def test_a_plain_lane_of_0_keeps_the_order_from_the_calibration(running: Firmware) -> None:
    """The calibration leaves order 3 to a loaded plain lane of amplitude 0: the disc has order 3
    only with the direction, which another lane of the file corrects."""
    modulators(running)
    bank = file_of({3: (0.0, 0.0)})
    last = Coefficients.from_harmonics([3], [20.0 * COUNTS / 1_296_000], [0.7], COUNTS, 1)
    arrays = {
        name: np.append(getattr(bank, name)[:-1], getattr(last, name))
        for name in ("phase_steps", "phase_offsets", "amplitudes")
    }
    extension = Extension(conditions=CONDITIONS, modulators=((LANES - 1, "direction"),))
    bank = dataclasses.replace(bank, **arrays, extension=extension)
    assert set(send(running, load_frames(bank))) == {"ok"}
    for seed, direction in ((5, 1), (6, -1), (7, 1)):
        orders = {**DISC.orders, 3: (20.0, 0.7 + (0.0 if direction > 0 else np.pi))}
        telemetry = running.turn(
            counts_of(Disc(orders), 0.1, seed, samples=SAMPLES, direction=direction)
        )
    assert state(running) == "load active"
    assert "loaded_order 3\r\n" in running.send("load status")
    verdicts = {row[0]: row[4] for row in telemetry["harmonics"]}
    assert verdicts[3] == 0


@pytest.mark.parametrize(("word", "value"), [("a", 1.0), ("a", -0.3), ("b", -1.0), ("b", 0.0)])
def test_a_word_goes_to_its_register(running: Firmware, word: str, value: float) -> None:
    """The console writes the word in the format s1.16, rounded to the nearest value."""
    modulators(running)
    assert running.send(f"word {word} {value}").strip() == "ok"
    assert running.core.get(f"conditions.word_{word}") == round(value * 65536) % 2**32
    other = "b" if word == "a" else "a"
    assert address(f"conditions.word_{other}") not in dict(running.core.writes)


def test_a_wrong_word_is_refused(running: Firmware) -> None:
    assert "no_modulators" in running.send("word a 0.5")
    modulators(running)
    for line in ("word c 0.5", "word a 1.01", "word a -2", "word b much", "word a"):
        assert running.send(line).startswith("error"), line
    written = dict(running.core.writes)
    assert address("conditions.word_a") not in written
    assert address("conditions.word_b") not in written
