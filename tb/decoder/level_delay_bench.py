"""Tests in cocotb that level_delay delays its inputs by the chosen number of clocks."""

from __future__ import annotations

import random
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

LONGEST = 255


@cocotb.test()
async def every_delay(dut: Any) -> None:
    """The outputs equal the delayed inputs for all 256 delays, with random levels in every
    clock."""
    choose = random.Random(1)
    dut.levels.value = 0
    dut.delay.value = 0
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    await RisingEdge(dut.clock)
    before = [0] * (LONGEST + 1)
    for delay in [*range(LONGEST + 1), LONGEST, 0, 1]:
        dut.delay.value = delay
        for clock in range(40):
            now = choose.randrange(8)
            dut.levels.value = now
            await RisingEdge(dut.clock)
            before = [now, *before[:LONGEST]]
            if clock > 2:
                assert int(dut.delayed.value) == before[delay], f"delay {delay}, clock {clock}"
