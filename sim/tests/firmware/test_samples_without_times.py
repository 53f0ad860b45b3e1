"""Tests that the firmware judges sets by turns whose samples have no known times, because they were
taken at equal angles or at edges of ``sync_in``."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.calibration.synthetic import COUNTS
from sim.tests.firmware.model_core import Firmware, address
from sim.tests.firmware.test_application import SAMPLES
from sim.tests.firmware.test_load import (
    DISC,
    LEFT_ARCSEC,
    SUBDIVISION,
    file_of,
    left,
    load,
    running,
    send,
    state,
    turn,
)
from sim.tests.firmware.test_load_followed import (
    LANES,
    LOOSE,
    loose_file,
    loose_turn,
    modulators,
)
from sim.tests.firmware.test_save import Board, re_armed, working

from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import Conditions

__all__ = ["running", "working"]

CASES = ["sync", "by_angle"]
PERIOD_CLOCKS = 100_000
"""Preset of the parameter ``sample_period``."""
CLOCK_HZ = 1e8
WHEEL = 1 << 32


def drop_the_times(made: Firmware, how: str) -> None:
    """Let the firmware capture without known times: by the operator's order, or because the speed
    of a turn swings by ±19 %."""
    if how == "sync":
        assert made.send("sync capture 1").strip() == "ok"
        return
    part = np.linspace(0.0, 1.01, SAMPLES)
    theta = 2.0 * np.pi * (part + 0.03 * np.sin(2.0 * np.pi * part))
    telemetry = made.turn(DISC.heads(theta, 0.1, np.random.default_rng(5)))
    assert telemetry["reason"] == "wrong_step"
    assert made.application.by_angle


@pytest.mark.parametrize("how", CASES)
def test_a_waiting_set_is_judged(running: Firmware, how: str) -> None:
    assert load(running, file_of(SUBDIVISION)) == "ok"
    drop_the_times(running, how)
    assert running.turn(turn(seed=6))["result"] == "applied"
    assert state(running) == "load active"
    assert left(running) < LEFT_ARCSEC


@pytest.mark.parametrize("how", CASES)
def test_a_loaded_set_is_watched(working: Board, how: str) -> None:
    drop_the_times(working.firmware, how)
    telemetry = working.firmware.turn(turn(seed=8))
    assert telemetry["result"] in ("applied", "kept")
    assert 0.0 < telemetry["loaded_arcsec"] < LEFT_ARCSEC
    assert left(working.firmware) < LEFT_ARCSEC


@pytest.mark.parametrize("how", CASES)
def test_a_pending_set_is_judged_again(working: Board, how: str) -> None:
    re_armed(working, "rearm")
    assert state(working.firmware) == "load waiting"
    drop_the_times(working.firmware, how)
    assert working.firmware.turn(turn(seed=8))["result"] == "applied"
    assert state(working.firmware) == "load active"
    # The next turns add the orders of the calibration.
    working.work(range(9, 12))
    assert left(working.firmware) < LEFT_ARCSEC


@pytest.mark.parametrize("how", CASES)
def test_a_saved_set_is_judged(working: Board, how: str) -> None:
    """A saved ``sync_capture`` is already on at power-on."""
    if how == "sync":
        drop_the_times(working.firmware, how)
    assert working.order("save").startswith("ok, record 1")
    working.power_on()
    if how == "by_angle":
        drop_the_times(working.firmware, how)
    assert working.status("saved") == ["waiting"]
    assert working.firmware.turn(turn(seed=8))["result"] == "applied"
    assert working.status("saved") == ["confirmed"]
    assert left(working.firmware) < LEFT_ARCSEC


def set_wide(made: Firmware, path: str, value: int) -> None:
    at = address(path)
    made.core.words[at], made.core.words[at + 4] = value % WHEEL, value // WHEEL


def timed_turn(made: Firmware, counts: NDArray[Any], late_samples: int = 0) -> dict[str, Any]:
    """Hand over a turn whose first sample was taken shortly before the low word of the time wraps.
    The firmware reads the registers ``late_samples`` periods after the last sample, and head 1
    moves on meanwhile with the same speed."""
    first, last, steps = int(counts[0, 0]), int(counts[0, -1]), counts.shape[1] - 1
    start = 7 * WHEEL - PERIOD_CLOCKS
    made.core.hand_over(counts, travel=round((last - first) / steps * late_samples))
    set_wide(made, "capture_header.start_time", start)
    set_wide(made, "snapshot.time", start + (steps + late_samples) * PERIOD_CLOCKS)
    made.send("telemetry on")
    telemetry: dict[str, Any] = json.loads(made.step(4))
    return telemetry


def speed_file() -> Coefficients:
    """Return the file of ``loose_file`` with order 1 × speed in the lane before the last. A turn of
    ``loose_turn`` has half the nominal speed."""
    file = loose_file()
    last = Coefficients.from_harmonics([1], [5.0 * COUNTS / 1_296_000], [0.2], COUNTS, 1)
    arrays = {
        name: getattr(file, name).copy() for name in ("phase_steps", "phase_offsets", "amplitudes")
    }
    for name, values in arrays.items():
        values[-2] = getattr(last, name)[0]
    nominal_deg_s = 2.0 * 360.0 / (SAMPLES * PERIOD_CLOCKS / CLOCK_HZ)
    extension = Extension(
        conditions=Conditions(16 * 700, 4, nominal_deg_s),
        modulators=((LANES - 2, "speed"), (LANES - 1, "direction")),
    )
    return dataclasses.replace(file, **arrays, extension=extension)


@pytest.mark.parametrize("how", [*CASES, "equal_times"])
@pytest.mark.parametrize("late_samples", [0, 300])
@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("turns_before", [0, 127])
def test_the_mean_speed_of_the_turn_is_its_motion(
    running: Firmware, how: str, late_samples: int, direction: int, turns_before: int
) -> None:
    """The firmware multiplies a lane by half at half the nominal speed, however the samples were
    taken, and also if the counts pass ±2³¹ meanwhile.

    Telemetry states the standard uncertainty of an order divided by the modulator of its lane. The
    modulator of the direction is ±1, so the uncertainties of the two lanes have the quotient 2. The
    bound 1e-3 covers the speed of head 1, which an eccentricity of 150″ changes by 7e-4 within the
    turn.
    """
    modulators(running)
    if how != "equal_times":
        drop_the_times(running, how)
    assert set(send(running, load_frames(speed_file()))) == {"ok"}
    counts = loose_turn(5, direction) + direction * turns_before * COUNTS
    telemetry = timed_turn(running, counts, late_samples)
    by_speed, by_direction = telemetry["followed"]
    assert (by_speed[1], by_direction[1]) == ("speed", "direction")
    assert by_speed[3] / by_direction[3] == pytest.approx(2.0, rel=1e-3)
    # The part of order 1 that changes sign with the direction gives the sign of the motion.
    assert abs(by_direction[2] - LOOSE[1][0]) < 5.0 + 0.3
