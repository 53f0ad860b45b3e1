"""Tests that pulse_output makes pulses of the chosen width, also from strobes during a pulse."""

from __future__ import annotations

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, FallingEdge

CLOCKS = 3000


@cocotb.test()
@cocotb.parametrize(width=[0, 1, 2, 7, 300])
async def as_long_as_asked_for(dut, width: int) -> None:
    random = np.random.default_rng(width)
    strobe = random.random(CLOCKS) < 1 / (width + 5)
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.width.value = width
    dut.reset.value = 1
    dut.strobe.value = 0
    await ClockCycles(dut.clock, 3, FallingEdge)
    dut.reset.value = 0
    seen = []
    for asks in strobe.tolist():
        dut.strobe.value = asks
        await FallingEdge(dut.clock)
        seen.append(int(dut.pulse.value))
    expected = np.convolve(strobe, np.ones(max(width, 1)))[:CLOCKS] > 0
    assert np.array_equal(seen, expected)
