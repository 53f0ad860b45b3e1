"""Tests that the pins of encoder_source_top stay constant in the reset, then count evenly."""

from __future__ import annotations

import os
from itertools import pairwise
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import Timer
from cocotb.utils import get_sim_time

PERIOD_NS = 8
HEADS = range(1, int(os.environ.get("HEADS", "2")) + 1)
RESET_CLOCKS = 64
COUNTS_A_CLOCK = 1_398_101 / 125e6
"""Counts per clock of the board's oscillator at 30 deg/s, 2²⁴ counts per turn
(docs/hardware.md)."""
CLOCKS = 18_000
"""Number of clocks; the last head has edges, with coefficients applied, from clock 14,000 on."""
LEAST_EDGES = 30
TAKEN_OVER = 4
"""Number of first edges that the test leaves out; up to 2 of them bring the output, when it is
enabled, to the levels of the position."""
SLOPE = (1864 + 2 * 78) * 2 * np.pi / 2**24
"""Largest slope of ε of equation (2), in counts per count, for the amplitudes of encoder_source."""


async def note_edges(pin: Any, name: str, noted: list[tuple[float, str, int]]) -> None:
    while True:
        await pin.value_change
        noted.append((get_sim_time("ns") / PERIOD_NS, name, int(pin.value)))


@cocotb.test()
async def all_heads_turn_at_30_degrees_a_second(dut: Any) -> None:
    cocotb.start_soon(Clock(dut.oscillator, PERIOD_NS, unit="ns", impl="gpi").start())
    noted: dict[int, list[tuple[float, str, int]]] = {head: [] for head in HEADS}
    await Timer(1, unit="ns")
    for head, edges in noted.items():
        for name in ("a", "b"):
            pin = getattr(dut, f"head{head}_{name}")
            cocotb.start_soon(note_edges(pin, name, edges))
    await Timer(CLOCKS * PERIOD_NS, unit="ns")
    for head, all_edges in noted.items():
        assert len(all_edges) >= LEAST_EDGES, f"head {head}: {len(all_edges)} edges"
        assert all_edges[0][0] > RESET_CLOCKS
        edges = all_edges[TAKEN_OVER:]
        clocks = np.array([clock for clock, _, _ in edges])
        for (_, before, level_before), (_, name, level) in pairwise(edges):
            # A and B never change together, and they count forwards: after an edge of A their
            # levels differ.
            assert name != before
            assert (level != level_before) == (name == "a")
        expected = COUNTS_A_CLOCK * (clocks[-1] - clocks[0])
        # The first and the last edge may each be a clock late, and the position is truncated to a
        # count.
        bound = 1 + SLOPE * expected + 2 * COUNTS_A_CLOCK
        assert abs(len(edges) - 1 - expected) <= bound, f"head {head}: {len(edges) - 1} counts"
