"""Checks the speed that table_speed measures on an eccentric disc at the paper's scale, in cocotb:
2²⁴ counts per turn, 30°/s."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge

from arctrue.generated.number_formats import CORRECTION_FRACTION, SPEED_WINDOW_BITS

COUNTS = 1 << 24
PACE = 30.0 / 360.0 * COUNTS / 100e6
"""Speed in counts per clock."""
SWING = 8e-4
"""Amplitude of the relative change of the reading's speed that the disc's eccentricity causes."""
ECCENTRICITY = SWING * COUNTS / (2.0 * np.pi)
"""Amplitude of order 1 of the reading's error, counts."""
WINDOW = 1 << SPEED_WINDOW_BITS
CLOCKS = 4 * WINDOW
UNIT = 1 << CORRECTION_FRACTION
PLACES = 4
"""Number of places of the turn, evenly spaced. At place 0 the reading is faster by SWING; half a
turn later it is slower by SWING."""
BOUND = 1.0 / WINDOW + 2.0 / UNIT / (PACE * WINDOW)
"""Largest relative error in the corrected angle: one clock and two units of the angle per window.
It is 6.5·10⁻⁵; the limit is 2·10⁻⁴."""


def edges(place: float, *, corrected: bool) -> Iterator[tuple[int, int, int]]:
    """Yield for each edge of the reading, from the angle ``place`` in counts on, its clock, the
    position and the correction, which is 0 if not ``corrected``."""
    turn = 2.0 * np.pi / COUNTS
    angle = place + PACE * np.arange(CLOCKS)
    reading = np.floor(angle + ECCENTRICITY * np.sin(turn * angle)).astype(np.int64)
    for clock in (np.flatnonzero(np.diff(reading)) + 1).tolist():
        now = float(reading[clock])
        true = now
        for _ in range(6):
            # Solves the equation of the reading for the angle; each step multiplies the error by up
            # to SWING.
            true = now - ECCENTRICITY * np.sin(turn * true)
        error = round((now - true) * UNIT) if corrected else 0
        yield clock, int(now) - ((error + UNIT // 2) // UNIT), error


async def measured_error(dut: Any, place: float, *, corrected: bool) -> float:
    """Return the largest relative error of the measured speed from ``place`` on."""
    dut.reset.value = 1
    at, found = 0, []
    for clock, position, correction in edges(place, corrected=corrected):
        await ClockCycles(dut.clock, clock - at)
        at = clock
        dut.position.value, dut.correction.value = position, correction
        dut.reset.value = int(clock < 1000)
        # The outputs keep the values of the last window, so that each edge may read them.
        if clock > 2000 + WINDOW:
            assert dut.is_bound.value == 0
            found.append(int(dut.travel.value) / UNIT / int(dut.elapsed.value) / PACE - 1.0)
    assert found
    return float(np.abs(found).max())


@cocotb.test()
async def the_speed_in_the_corrected_angle(dut: Any) -> None:
    """In the corrected angle the error of the speed is at most BOUND anywhere in the turn; in the
    reading it reaches SWING."""
    dut.position.value = dut.correction.value = 0
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    await RisingEdge(dut.clock)
    for number in range(PLACES):
        place = number * COUNTS / PLACES
        assert await measured_error(dut, place, corrected=True) <= BOUND, number
    uncorrected = await measured_error(dut, 0.0, corrected=False)
    assert abs(uncorrected - SWING) <= BOUND
