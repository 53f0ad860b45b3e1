"""Tests when the fabric's reset begins and ends if the processor's reset changes at any time within
a clock."""

from __future__ import annotations

from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge, Timer

CLOCKS = 16
CLOCK_NS = 10
SYNCHRONISER_CLOCKS = 2


async def edges_until(dut: Any, level: int) -> int:
    """Return the number of rising edges of the clock until ``reset`` has ``level``."""
    for edges in range(1, 200):
        await RisingEdge(dut.clock)
        await FallingEdge(dut.clock)
        if int(dut.reset.value) == level:
            return edges
    raise AssertionError(f"reset did not become {level}")


@cocotb.test()
async def held_from_power_up_without_any_edge(dut: Any) -> None:
    """If `asynchronous_reset_n` is high from power-up on, `reset` is active at first, and then
    ends."""
    dut.asynchronous_reset_n.value = 1
    cocotb.start_soon(Clock(dut.clock, CLOCK_NS, unit="ns", impl="gpi").start())
    await Timer(1, "ns")
    assert int(dut.reset.value) == 1
    # The clock's first rising edge may come before edges_until starts to count.
    assert CLOCKS <= await edges_until(dut, 0) <= CLOCKS + SYNCHRONISER_CLOCKS + 1


@cocotb.test()
async def begins_and_ends_with_the_clock(dut: Any) -> None:
    cocotb.start_soon(Clock(dut.clock, CLOCK_NS, unit="ns", impl="gpi").start())
    for offset_ns in range(1, CLOCK_NS):
        if offset_ns == CLOCK_NS // 2:
            continue  # the falling edge, at which this test reads `reset`
        dut.asynchronous_reset_n.value = 1
        while int(dut.reset.value):
            await FallingEdge(dut.clock)
        await RisingEdge(dut.clock)
        await Timer(offset_ns, "ns")
        dut.asynchronous_reset_n.value = 0
        assert await edges_until(dut, 1) == SYNCHRONISER_CLOCKS + 1
        for _ in range(5):
            await FallingEdge(dut.clock)
            assert int(dut.reset.value) == 1
        await RisingEdge(dut.clock)
        await Timer(offset_ns, "ns")
        dut.asynchronous_reset_n.value = 1
        assert await edges_until(dut, 0) == SYNCHRONISER_CLOCKS + CLOCKS + 1


@cocotb.test()
async def a_second_reset_starts_the_hold_anew(dut: Any) -> None:
    cocotb.start_soon(Clock(dut.clock, CLOCK_NS, unit="ns", impl="gpi").start())
    dut.asynchronous_reset_n.value = 0
    for _ in range(6):
        await FallingEdge(dut.clock)
    dut.asynchronous_reset_n.value = 1
    for _ in range(CLOCKS // 2):
        await FallingEdge(dut.clock)
    dut.asynchronous_reset_n.value = 0
    for _ in range(4):
        await FallingEdge(dut.clock)
    dut.asynchronous_reset_n.value = 1
    assert await edges_until(dut, 0) == SYNCHRONISER_CLOCKS + CLOCKS + 1
