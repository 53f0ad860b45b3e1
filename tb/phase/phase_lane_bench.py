"""Compares phase_lane with its model in cocotb tests."""

from __future__ import annotations

from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from numpy.typing import NDArray

from arctrue.gateware.phase_lane import phase_lane
from arctrue.generated.number_formats import PHASE_LATENCY, PHASE_OFFSET_CLOCK


async def start(dut: Any) -> None:
    dut.angle.value = 0
    dut.phase_step.value = 0
    dut.phase_offset.value = 0
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(PHASE_LATENCY + 1):
        await RisingEdge(dut.clock)


async def compare(
    dut: Any,
    angle: NDArray[np.int64],
    step: NDArray[np.int64],
    offset: NDArray[np.int64],
) -> None:
    """Compare the phases with the model's; every input changes in every clock."""
    await start(dut)
    seen = []
    last = angle.size - 1
    for clock in range(angle.size + PHASE_LATENCY):
        dut.angle.value = int(angle[min(clock, last)])
        dut.phase_step.value = int(step[min(clock, last)])
        dut.phase_offset.value = int(offset[min(max(clock - PHASE_OFFSET_CLOCK, 0), last)])
        await RisingEdge(dut.clock)
        seen.append(dut.phase.value.to_unsigned())
    found = np.array(seen[PHASE_LATENCY:])
    expected = phase_lane(angle, step, offset)
    wrong = np.flatnonzero(found != expected)
    assert not wrong.size, (
        f"angle {angle[wrong[0]]}, step {step[wrong[0]]}, offset {offset[wrong[0]]}: "
        f"{found[wrong[0]]}, expected {expected[wrong[0]]} ({wrong.size} differ)"
    )


@cocotb.test()
async def random_words(dut: Any) -> None:
    rng = np.random.default_rng(1)
    await compare(
        dut,
        rng.integers(0, 2**24, 20_000),
        rng.integers(0, 2**48, 20_000),
        rng.integers(0, 2**24, 20_000),
    )


@cocotb.test()
async def extremes(dut: Any) -> None:
    """The phases equal the model's for words with a single bit, with all bits, and with bits next
    to those at which the words are divided among the three multipliers."""
    angles = [0, 1, 2**14 - 1, 2**14, 2**23, 2**24 - 1]
    steps = [0, *(2**bit for bit in range(48)), *(2**bit - 1 for bit in range(1, 49))]
    offsets = [0, 2**24 - 1]
    words = np.array(
        [(angle, step, offset) for angle in angles for step in steps for offset in offsets]
    )
    await compare(dut, *words.T)


@cocotb.test()
async def latency_is_five_clocks(dut: Any) -> None:
    """At the ports, the phase comes 5 clocks after angle and step, 3 clocks after the offset."""
    await start(dut)
    dut.angle.value = 1
    dut.phase_step.value = 2**40
    for _ in range(10):
        await RisingEdge(dut.clock)
    for name, value, expected in (
        ("angle", 3, PHASE_LATENCY),
        ("phase_step", 2**42, PHASE_LATENCY),
        ("phase_offset", 5, PHASE_LATENCY - PHASE_OFFSET_CLOCK),
    ):
        before = dut.phase.value
        getattr(dut, name).value = value
        clocks = 0
        await RisingEdge(dut.clock)
        while dut.phase.value == before:
            assert clocks < 20, name
            clocks += 1
            await RisingEdge(dut.clock)
        assert clocks == expected, f"{name}: {clocks} clocks"
    assert PHASE_LATENCY == 5
