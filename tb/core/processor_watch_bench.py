"""Tests that processor_watch raises `silent` exactly when the time limit has passed."""

from __future__ import annotations

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

CLOCKS = 6000


@cocotb.test()
@cocotb.parametrize(limit=[0, 1, 2, 17, 40])
async def silent_after_the_limit(dut, limit: int) -> None:
    random = np.random.default_rng(limit)
    alive = random.random(CLOCKS) < 1 / (limit + 3)
    reset = random.random(CLOCKS) < 0.003
    reset[0] = True
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.limit.value = limit
    await FallingEdge(dut.clock)
    silent = []
    for is_alive, resets in zip(alive.tolist(), reset.tolist(), strict=True):
        dut.alive.value = is_alive
        dut.reset.value = resets
        await FallingEdge(dut.clock)
        silent.append(int(dut.silent.value))
    last_alive = np.maximum.accumulate(np.where(alive | reset, np.arange(CLOCKS), 0))
    expected = (np.arange(CLOCKS) - last_alive > limit) & (limit > 0)
    assert np.array_equal(silent, expected)
    assert expected.any() == (limit > 0)


@cocotb.test()
async def a_long_limit_is_counted_whole(dut) -> None:
    """With a limit of more than 16 bits, ``silent`` rises in the first clock after the limit."""
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.reset.value = 1
    dut.alive.value = 0
    dut.limit.value = 70_000
    await FallingEdge(dut.clock)
    dut.reset.value = 0
    for clocks, silent in ((70_000, 0), (1, 1), (100, 1)):
        for _ in range(clocks):
            await FallingEdge(dut.clock)
        assert int(dut.silent.value) == silent
