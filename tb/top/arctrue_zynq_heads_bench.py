"""Tests in cocotb that the pins of each of four heads give this head's column of the capture."""

from __future__ import annotations

from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, FallingEdge

from arctrue.gateware.register_access import RegisterMap
from arctrue.generated import registers
from tb.core import arctrue_core_table as table
from tb.core.mean_core_bench import COUNTS, HEADS, PINS, readings
from tb.top.arctrue_zynq_bench import BASE, CLOCK_NS, DECERR, RESET_CLOCKS, RESET_RELEASE_CLOCKS
from tb.top.axi3_master import Axi3Master

CLOCKS_PER_COUNT = 5.0
START = -150.0
SAMPLE_PERIOD = 64


def drive(dut: Any, row: list[int]) -> None:
    levels = [table.pins(reading) >> bit & 1 for reading in row for bit in range(3)]
    for name, level in zip(PINS, levels, strict=True):
        getattr(dut, name).value = level


async def turn(dut: Any, clock: Any, angle: np.ndarray[Any, np.dtype[np.float64]]) -> None:
    before: list[int] = []
    for row in readings(angle).tolist():
        if row != before:
            drive(dut, row)
            before = row
        await FallingEdge(clock)


@cocotb.test()
async def each_head_has_its_pins(dut: Any) -> None:
    """Each row of both capture windows, read in bursts over AXI3, has the readings of all heads in
    one clock."""
    assert HEADS == 4
    ps7 = dut.device.device.processor.ps7_primitive
    clock, axi = ps7.fabric_clock, Axi3Master(ps7)
    ps7.fabric_resetn.value = 0
    drive(dut, readings(np.array([START]))[0].tolist())
    cocotb.start_soon(Clock(clock, CLOCK_NS, unit="ns", impl="gpi").start())
    await ClockCycles(clock, RESET_CLOCKS)
    ps7.fabric_resetn.value = 1
    await ClockCycles(clock, RESET_RELEASE_CLOCKS)
    names = RegisterMap(axi.read_words, axi.write_words, base=BASE)
    assert await names.read_fields("capability") == {
        "heads": 4,
        "mean": 1,
        "rotation": 0,
        "modulators": 0,
        "real_orders": 0,
        "local_table": 0,
        "failover": 0,
        "events": 0,
    }
    # The register map has 512 KiB; the bridge refuses the address after its last word.
    (answer,) = await axi.read_burst(BASE + registers.MAP_BYTES, 1)
    assert answer[1] == DECERR
    await names.write("counts_per_rev", COUNTS)
    await names.command("rearm")
    await names.write("sample_period", SAMPLE_PERIOD)
    angle = START + np.arange(0.0, 2 * COUNTS + 450.0, 1.0 / CLOCKS_PER_COUNT)
    half = int((COUNTS - START) * CLOCKS_PER_COUNT)
    await turn(dut, clock, angle[:half])
    assert await names.read("heads_status.index_seen") == 0b1111
    await names.update("control", capture_enable=1)
    await turn(dut, clock, angle[half:])
    assert await names.read("status.capture_ready") == 1
    bank = await names.read_capture(HEADS)
    # The number of samples may be larger by the sample that closes the turn, and may vary by one
    # because of the error of head 1, which is smaller than the distance of two samples.
    assert abs(len(bank.samples) - COUNTS * CLOCKS_PER_COUNT / SAMPLE_PERIOD) <= 2
    known = {tuple(row) for row in (readings(angle) % COUNTS).tolist()}
    assert all(tuple(row) in known for row in (bank.samples % COUNTS).tolist())
