"""Tests the bounds that the pages of stop_operator and table_speed state for a servo that reads the
corrected angle."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.gateware.stop_operator import StopOperator
from arctrue.gateware.table_speed import TableSpeed
from arctrue.generated.number_formats import CORRECTION_FRACTION, SPEED_WINDOW_BITS, STOP_FRACTION

WINDOW_BITS = 10
WINDOW = 1 << WINDOW_BITS
"""Clocks of a window in the model, a sixteenth of those of the gateware; frequencies and latency
are in proportion to the window."""
PACE = 0.3
"""Counts per clock of the steady motion."""
VIBRATION_COUNTS = 60.0


def loop(latency: float, frequency: float, windows: int = 80) -> complex:
    """Return the output's vibration divided by the table's, if a lane that follows the speed
    corrects a latency. ``latency`` is in clocks, ``frequency`` in periods per clock."""
    speed = TableSpeed(window=WINDOW_BITS)
    clock = np.arange(windows * WINDOW)
    swing = VIBRATION_COUNTS * np.sin(2.0 * np.pi * frequency * clock)
    place = PACE * clock + swing
    position = np.floor(place).astype(np.int64)
    correction = 0
    output = np.empty(clock.size)
    for number, reading in enumerate(position.tolist()):
        output[number] = reading - correction / (1 << CORRECTION_FRACTION)
        found = speed.move(reading, correction)
        if found is not None and not found.is_bound:
            ratio = found.travel / found.elapsed * (-1 if found.is_down else 1)
            correction = round(-latency * ratio)
    # The measurement settles in the first quarter; the rows are whole periods after it.
    first = clock.size // 4
    periods = int((clock.size - first) * frequency)
    rows = slice(first, first + round(periods / frequency))
    wave = np.exp(-2j * np.pi * frequency * clock[rows])
    steady = np.polynomial.polynomial.Polynomial.fit(clock[rows], output[rows] - swing[rows], 1)
    seen = output[rows] - steady(clock[rows])
    return complex(np.sum(seen * wave) / np.sum(swing[rows] * wave))


@pytest.mark.parametrize("latency_us", [5.0, 20.0, 50.0])
@pytest.mark.parametrize("windows_a_period", [8, 11, 17, 40])
def test_the_lead_of_a_latency_lane_is_bounded(latency_us: float, windows_a_period: int) -> None:
    """The bound is the lead 2πf·latency, plus the rounding of readings: a quarter of a count at an
    amplitude of 60. The gateware's window has 2¹⁴ clocks at 100 MHz; the test shortens the latency
    in proportion to the model's window."""
    latency = latency_us * 100.0 * 2.0 ** (WINDOW_BITS - SPEED_WINDOW_BITS)
    frequency = 1.0 / (windows_a_period * WINDOW)
    lead = 2.0 * np.pi * frequency * latency
    found = loop(latency, frequency)
    allowance = 0.25 / VIBRATION_COUNTS
    assert abs(found) <= 1.0 + lead + allowance
    assert np.angle(found) <= np.arcsin(lead) + allowance
    # The lane acts: without its correction the ratio is 1.
    assert abs(found - 1.0) > 0.5 * lead - allowance


def test_a_reversal_moves_the_output_within_its_bounds() -> None:
    """For any motion, the correction a·h (a: amplitude, h: output of the stop operator, W: its
    width) changes by at most a/W times the motion and by at most 2·a. Motion within the dead zone
    changes nothing."""
    width, dead_zone, amplitude = 700, 4, 300.0
    stop = StopOperator(width << STOP_FRACTION, dead_zone)
    random = np.random.default_rng(6)
    speeds = np.repeat(random.integers(-3, 4, 400), random.integers(1, 600, 400))
    position = np.cumsum(speeds)
    found = [stop.move(int(one)) for one in position]
    known = np.array([one for _, one in found])
    part = amplitude * np.array([place for place, _ in found]) / (width << STOP_FRACTION)
    first = int(np.argmax(known))
    assert known[first:].all()
    assert first < known.size // 2
    moved, changed = np.diff(position[first:]), np.diff(part[first:])
    assert np.all(np.abs(changed) <= amplitude / width * np.abs(moved) + 1e-9)
    assert np.all(changed * moved >= 0.0)
    assert np.ptp(part[first:]) == pytest.approx(2.0 * amplitude)
    before = stop.move(int(position[-1]))
    end = int(position[-1])
    stop.move(end + 2 * dead_zone)
    settled = stop.move(end + 2 * dead_zone)
    for tremble in (1, dead_zone, 0, 2):
        assert stop.move(end + 2 * dead_zone - tremble) == settled
    assert before[1]
