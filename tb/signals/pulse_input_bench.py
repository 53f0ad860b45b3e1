"""Tests that pulse_input gives one strobe for each active edge whose level lasts long enough."""

from __future__ import annotations

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, FallingEdge

from arctrue.gateware.glitch_filter import glitch_filter

CLOCKS = 5000
STAGES = 2


@cocotb.test()
@cocotb.parametrize(filter_length=[1, 3, 20], falling=[0, 1])
async def one_for_each_edge(dut, filter_length: int, falling: int) -> None:
    random = np.random.default_rng(filter_length)
    pin = np.cumsum(random.random(CLOCKS) < 1 / (2 * filter_length + 4)) % 2
    reset = np.arange(CLOCKS) < 3
    reset[2000] = True
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.filter_length.value = filter_length
    dut.falling_edge.value = falling
    await FallingEdge(dut.clock)
    strobes = []
    for level, resets in zip(pin.tolist(), reset.tolist(), strict=True):
        dut.pin.value = level
        dut.reset.value = resets
        await FallingEdge(dut.clock)
        strobes.append(int(dut.strobe.value))
    quiet = np.zeros(CLOCKS, dtype=bool)
    for begin in np.flatnonzero(reset):
        quiet[begin : begin + STAGES + 2 + filter_length] = True
    filtered = glitch_filter(pin, np.full(CLOCKS, filter_length), np.zeros(CLOCKS, dtype=bool))[1:]
    edges = np.diff(np.concatenate([[0], filtered])) == (-1 if falling else 1)
    # The model contains the filter's latency; the clocks of the synchroniser and of the strobe's
    # register are added here.
    expected = np.concatenate([np.zeros(STAGES + 1, dtype=bool), edges])[:CLOCKS]
    settled = ~quiet
    settled[2000 - filter_length : 2000 + 3 * filter_length + 8] = False
    assert np.array_equal(np.array(strobes)[settled], expected[settled])
    assert expected.sum() > 20


@cocotb.test()
async def latency_is_four_clocks(dut) -> None:
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.filter_length.value = 1
    dut.falling_edge.value = 0
    dut.pin.value = 0
    dut.reset.value = 1
    await ClockCycles(dut.clock, 3, FallingEdge)
    dut.reset.value = 0
    for _ in range(20):
        await FallingEdge(dut.clock)
        assert not int(dut.strobe.value)
    dut.pin.value = 1
    seen = []
    for _ in range(8):
        await FallingEdge(dut.clock)
        seen.append(int(dut.strobe.value))
    assert seen == [0, 0, 0, 1, 0, 0, 0, 0]


@cocotb.test()
@cocotb.parametrize(level=[0, 1])
async def a_reset_is_no_edge(dut, level: int) -> None:
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.filter_length.value = 1
    dut.falling_edge.value = 0
    dut.pin.value = level
    dut.reset.value = 1
    await ClockCycles(dut.clock, 3, FallingEdge)
    dut.reset.value = 0
    for _ in range(30):
        await FallingEdge(dut.clock)
        assert not int(dut.strobe.value)
