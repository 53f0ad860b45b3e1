"""Compares the VHDL plausibility check with its model."""

from __future__ import annotations

from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from arctrue.gateware.edge_counter import counted_edges
from arctrue.gateware.plausibility_check import plausibility_check
from arctrue.generated.number_formats import COUNTS_PER_PERIOD, FAULT_COUNT_MAX
from tb.decoder.drive import edge_ports, follows

CLOCKS = 12_000


def levels(random: np.random.Generator, chance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return levels of A and B. In each stretch of 60 clocks they count up, count down or stand
    still; when they count, it is by ``chance`` counts per clock on average. Sometimes both change
    at once."""
    direction = np.repeat(random.integers(-1, 2, CLOCKS // 60), 60)
    place = np.cumsum(np.where(random.random(CLOCKS) < chance, direction, 0))
    place += 2 * np.cumsum(random.random(CLOCKS) < 0.03)
    b = (place % 4 >= 2).astype(np.int64)
    return b ^ (place % 2), b


@cocotb.test()
async def faults_of_unrelated_edges(dut: Any) -> None:
    """The faults equal the model's for levels and counted edges that are independent of each other,
    so that every combination occurs."""
    random = np.random.default_rng(12)
    reset = random.random(CLOCKS) < 0.001
    reset[:3] = True
    settling = reset | (np.convolve(reset, np.ones(4), "full")[:CLOCKS] > 0)
    a, b = levels(random, 0.6)
    edges = counted_edges(*levels(random, 0.3), settling, reset)
    quarter = CLOCKS // 4
    given = {
        "filter_length": np.repeat([1, 2, 5, 0], quarter),
        "minimum_edge_spacing": np.repeat([0, 3, 2, 40], quarter),
        "clear": random.random(CLOCKS) < 0.01,
        "settling": settling,
        "reset": reset,
    }
    misplaced = random.random(CLOCKS) < 0.01
    trace = plausibility_check((a, b), edges, misplaced, **given)
    inputs = {**given, "a": a, "b": b, "misplaced": misplaced, **edge_ports(edges)}
    await follows(dut, inputs, vars(trace))
    assert all(values.any() for values in vars(trace).values())


@cocotb.test()
async def a_period_ahead(dut: Any) -> None:
    """If the levels change by a whole period while no edge is counted, a fault is reported at the
    fourth count, not before."""
    for name in ("a", "b", "comes", "moves", "up", "down", "breaks_order", "misplaced", "clear"):
        getattr(dut, name).value = 0
    dut.stands.value = 1
    dut.filter_length.value = 200
    dut.minimum_edge_spacing.value = 0
    dut.settling.value = dut.reset.value = 1
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    for _ in range(4):
        await FallingEdge(dut.clock)
    dut.settling.value = dut.reset.value = 0
    for count in range(1, COUNTS_PER_PERIOD + 1):
        dut.a.value = count % 4 in (1, 2)
        dut.b.value = count % 4 in (2, 3)
        # The fault appears 3 clocks after the levels.
        for _ in range(6):
            await FallingEdge(dut.clock)
        assert int(dut.swallowed.value) == (count == COUNTS_PER_PERIOD), f"after {count} counts"
        assert int(dut.overspeed_count.value) == (count == COUNTS_PER_PERIOD)


@cocotb.test()
async def counters_stop_at_their_end(dut: Any) -> None:
    """With a fault of each kind in every clock, the counters of faults stop at 65,535 and do not
    wrap."""
    for name in ("a", "b", "comes", "down", "clear", "settling", "filter_length", "stands"):
        getattr(dut, name).value = 0
    for name in ("moves", "up", "breaks_order", "misplaced", "reset"):
        getattr(dut, name).value = 1
    dut.minimum_edge_spacing.value = 2
    clock = Clock(dut.clock, 10, unit="ns", impl="gpi")
    clock.start()
    for _ in range(3):
        await FallingEdge(dut.clock)
    dut.reset.value = 0
    await clock.cycles(FAULT_COUNT_MAX + 100)
    await FallingEdge(dut.clock)
    for name in ("illegal_count", "overspeed_count", "index_error_count"):
        assert int(getattr(dut, name).value) == FAULT_COUNT_MAX, name
