"""Lanes that follow a condition, over the console into the registers."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from sim.tests.calibration.synthetic import COUNTS
from sim.tests.firmware.model_core import COEFFICIENTS, Firmware, address
from sim.tests.firmware.test_load import SUBDIVISION, file_of, running, send, state, turn

from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.extension import Conditions, Extension
from arctrue.gateware.register_access import coefficient_words

__all__ = ["running"]

LANES = 32
HALF_REVERSAL_COUNTS = 26.0
CONDITIONS = Conditions(16 * 700, 4, 45.0)


def with_direction(
    plain: dict[int, tuple[float, float]], conditions: Conditions = CONDITIONS
) -> Coefficients:
    """The orders of ``plain`` and, in the last lane, order 0 × direction."""
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


def test_they_come_to_the_last_lanes_beside_the_others(running: Firmware) -> None:
    """Words of the lane and of the window are those of the file; the calibration leaves them."""
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
    # The calibration's next turns keep them, and lose no order of theirs.
    for seed in (6, 7):
        running.turn(turn(seed))
        assert last_lane(running.core.active) == expected
    # A set without them takes them away.
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
    """Without the generic, without force, and where 26 counts go over within 50."""
    if built:
        modulators(running)
    frames = load_frames(with_direction(SUBDIVISION, conditions), force=force)
    *before, last = send(running, frames)
    assert set(before) == {"ok"}
    assert last.startswith(f"error: load {reason}")


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
