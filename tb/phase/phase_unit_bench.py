"""Compares phase_unit with its model in cocotb tests."""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.phase_unit import phase_unit
from arctrue.generated.number_formats import (
    PHASE_LATENCY,
    PHASE_OFFSET_CLOCK,
    PHASE_STEP_WIDTH,
    PHASE_WIDTH,
)
from tb.support.flat import flat, words

LANES = int(os.environ.get("LANES", "32"))
ANGLES = int(os.environ.get("ANGLES", "300"))


async def start(dut: Any) -> None:
    dut.angle.value = 0
    dut.phase_steps.value = 0
    dut.phase_offsets.value = 0
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(PHASE_LATENCY + 1):
        await RisingEdge(dut.clock)


@cocotb.test()
async def every_lane_has_its_own_words(dut: Any) -> None:
    """The phase of every lane is computed with this lane's words; all words change in every clock,
    and an offset comes two clocks after its angle."""
    rng = np.random.default_rng(LANES)
    angle = rng.integers(0, 2**24, ANGLES)
    steps = rng.integers(0, 2**48, (ANGLES, LANES))
    offsets = rng.integers(0, 2**24, (ANGLES, LANES))
    await start(dut)
    seen = []
    for clock in range(ANGLES + PHASE_LATENCY):
        now = min(clock, ANGLES - 1)
        dut.angle.value = int(angle[now])
        dut.phase_steps.value = flat(steps[now], PHASE_STEP_WIDTH)
        dut.phase_offsets.value = flat(
            offsets[min(max(clock - PHASE_OFFSET_CLOCK, 0), ANGLES - 1)], PHASE_WIDTH
        )
        await RisingEdge(dut.clock)
        seen.append(words(dut.phases.value.to_unsigned(), LANES, PHASE_WIDTH))
    found = np.array(seen[PHASE_LATENCY:])
    wrong = np.argwhere(found != phase_unit(angle, steps, offsets))
    assert not wrong.size, f"first at angle and lane {wrong[0]}, {len(wrong)} differ"


@cocotb.test()
async def latency_is_five_clocks(dut: Any) -> None:
    """At the ports, the phases of all lanes come five clocks after their angle."""
    await start(dut)
    dut.phase_steps.value = flat(np.full(LANES, 2**24), PHASE_STEP_WIDTH)
    for _ in range(10):
        await RisingEdge(dut.clock)
    dut.angle.value = 77
    clocks = 0
    await RisingEdge(dut.clock)
    while dut.phases.value.to_unsigned() == 0:
        assert clocks < 20
        clocks += 1
        await RisingEdge(dut.clock)
    assert words(dut.phases.value.to_unsigned(), LANES, PHASE_WIDTH) == [77] * LANES
    assert clocks == PHASE_LATENCY == 5
