"""Plays a file of pin changes into a recorder; `run` is low before the first change and after the
last."""

from __future__ import annotations

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge


@cocotb.test()
async def play_to_the_end(dut: object) -> None:
    dut.run.value = 0
    Clock(dut.clock, 10, unit="ns").start()
    await ClockCycles(dut.clock, 5)
    dut.run.value = 1
    await RisingEdge(dut.finished)
    await ClockCycles(dut.clock, 3)
    dut.run.value = 0
    await ClockCycles(dut.clock, 3)
