"""Compares the VHDL glitch filter with its model, for random pulses, filter lengths and resets."""

from __future__ import annotations

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from arctrue.gateware.glitch_filter import glitch_filter

WIDTH = 3
CLOCKS = 6000


@cocotb.test()
@cocotb.parametrize(
    # Each row has the mean number of clocks between changes of a level, and the filter lengths from
    # which the bench chooses.
    (("holds", "lengths"), [(1.5, [0, 1, 2]), (4, [1, 2, 3, 4, 5]), (200, [1, 100, 254, 255])])
)
async def follows_the_model(dut, holds: float, lengths: list[int]) -> None:
    random = np.random.default_rng(5)
    levels = np.cumsum(random.random((CLOCKS, WIDTH)) < 1 / holds, axis=0) % 2
    changes = np.cumsum(random.random(CLOCKS) < 0.003)
    length = random.choice(lengths, CLOCKS)[changes]
    reset = random.random(CLOCKS) < 0.002
    reset[0] = True
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await FallingEdge(dut.clock)
    got = []
    words = (levels << np.arange(WIDTH)).sum(axis=1).tolist()
    for word, clocks, loads in zip(words, length.tolist(), reset.tolist(), strict=True):
        dut.unfiltered.value = word
        dut.filter_length.value = clocks
        dut.reset.value = loads
        await FallingEdge(dut.clock)
        got.append(int(dut.filtered.value))
    for signal in range(WIDTH):
        expected = glitch_filter(levels[:, signal], length, reset)[1:]
        wrong = np.flatnonzero((np.array(got) >> signal & 1) != expected)
        assert not wrong.size, f"signal {signal} differs from the model after clock {wrong[0]}"
