"""Compares the VHDL edge counter with its model, for levels in any order."""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np

from arctrue.gateware.edge_counter import counted_edges, edge_counter
from tb.decoder.drive import edge_ports, follows

RESET_POSITION = int(os.environ["RESET_POSITION"])
CLOCKS = 6000


@cocotb.test()
async def counts_levels_in_any_order(dut: Any) -> None:
    """The counter equals its model while it counts up and down by up to an edge per clock, at
    illegal transitions, and at resets of any length."""
    random = np.random.default_rng(11)
    speed = np.repeat(random.integers(-1, 2, CLOCKS // 40), 40)
    place = np.cumsum(np.where(random.random(CLOCKS) < 0.7, speed, 0))
    # In some random clocks both pins change at once.
    place += 2 * np.cumsum(random.random(CLOCKS) < 0.02)
    b = (place % 4 >= 2).astype(np.int64)
    a = b ^ (place % 2)
    reset = random.random(CLOCKS) < 0.004
    reset[:3] = True
    preload = reset | (np.convolve(reset, np.ones(4), "full")[:CLOCKS] > 0)
    timestamp = np.arange(CLOCKS).astype(np.uint64) + np.uint64(2**64 - CLOCKS // 2)
    trace = edge_counter(a, b, preload, reset, timestamp, RESET_POSITION)
    inputs = {"a": a, "b": b, "reset": reset, "preload": preload, "timestamp": timestamp}
    ports = edge_ports(counted_edges(a, b, preload, reset))
    comes = ports.pop("comes")
    expected = vars(trace) | {name: np.append(values, 0) for name, values in ports.items()}
    # `comes` is checked in the clock of its inputs; the last clock is not driven, because no output
    # is read after it.
    inputs = {name: values[:-1] for name, values in inputs.items()}
    await follows(dut, inputs, expected, at_once={"comes": comes})
    assert trace.position.min() < RESET_POSITION < trace.position.max()
