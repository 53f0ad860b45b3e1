"""Measures how many clocks of the core GHDL simulates per second while the table turns and every
lane is active."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, FallingEdge, RisingEdge

from arctrue.gateware.register_access import coefficient_words, register_named
from arctrue.generated.registers import COEFFICIENTS_ADDRESS
from arctrue.instrument.speed import busy_coefficients

LEVELS = (0b00, 0b01, 0b11, 0b10)


async def write(dut, address: int, word: int) -> None:
    await FallingEdge(dut.clock)
    for name, value in (("awaddr", address), ("wdata", word), ("wstrb", 15)):
        getattr(dut, f"s_axil_{name}").value = value
    for name in ("awvalid", "wvalid", "bready"):
        getattr(dut, f"s_axil_{name}").value = 1
    pending = {"aw", "w", "b"}
    while pending:
        await RisingEdge(dut.clock)
        taken = {
            channel
            for channel in pending
            if getattr(dut, f"s_axil_{channel}{'valid' if channel == 'b' else 'ready'}").value == 1
        }
        pending -= taken
        await FallingEdge(dut.clock)
        for channel in taken - {"b"}:
            getattr(dut, f"s_axil_{channel}valid").value = 0


@cocotb.test()
async def turn(dut) -> None:
    lanes, clocks = int(os.environ["ARCTRUE_LANES"]), int(os.environ["ARCTRUE_CLOCKS"])
    for name in ("awvalid", "wvalid", "bready", "arvalid", "rready"):
        getattr(dut, f"s_axil_{name}").value = 0
    heads = [getattr(dut, f"head{head}_{pin}") for head in (1, 2) for pin in "abz"]
    for pin in heads:
        pin.value = 0
    dut.reset.value = 1
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await ClockCycles(dut.clock, 80)
    dut.reset.value = 0
    for place, word in enumerate(coefficient_words(busy_coefficients(lanes))):
        await write(dut, COEFFICIENTS_ADDRESS + 4 * place, word)
    await write(dut, register_named("command").address, 1)
    await write(dut, register_named("control").address, 3)
    started = time.process_time()
    for clock in range(clocks):
        count = clock * 10 // 11
        levels = LEVELS[count % 4]
        for pin, value in zip(heads, 2 * (levels & 1, levels >> 1, int(count == 50)), strict=True):
            pin.value = value
        await FallingEdge(dut.clock)
    took = time.process_time() - started
    answer = json.dumps({"clocks": clocks, "cpu_s": took})
    Path(os.environ["ARCTRUE_ANSWER"]).write_text(answer, encoding="utf-8")
