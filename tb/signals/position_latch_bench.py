"""Tests that an edge latches the values that the inputs have DELAY clocks later, and that a reset
discards a waiting edge."""

from __future__ import annotations

import os

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

DELAY = int(os.environ["DELAY"])
CLOCKS = 4000


@cocotb.test()
async def latches_the_clock_of_the_edge(dut) -> None:
    random = np.random.default_rng(DELAY)
    strobe = random.random(CLOCKS) < 0.05
    reset = np.zeros(CLOCKS, dtype=bool)
    reset[[0, 1500]] = True
    position = random.integers(-(2**31), 2**31, CLOCKS)
    angle = random.integers(0, 2**24, CLOCKS)
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await FallingEdge(dut.clock)
    edges, count = [], 0
    for clock in range(CLOCKS):
        dut.strobe.value = int(strobe[clock])
        dut.reset.value = int(reset[clock])
        dut.position.value = int(position[clock])
        dut.angle.value = int(angle[clock])
        dut.timestamp.value = 2**40 + clock
        await FallingEdge(dut.clock)
        if reset[clock]:
            edges, count = [], 0
        is_latched = bool(edges) and edges[0] == clock - DELAY
        assert int(dut.latched.value) == is_latched, clock
        if is_latched:
            edges.pop(0)
            count += 1
            assert dut.latched_position.value.to_signed() == position[clock]
            assert dut.latched_angle.value.to_unsigned() == angle[clock]
            assert dut.latched_time.value.to_unsigned() == 2**40 + clock - DELAY
        assert dut.count.value.to_unsigned() == count
        if strobe[clock] and not reset[clock]:
            edges.append(clock)
    assert count > 50
