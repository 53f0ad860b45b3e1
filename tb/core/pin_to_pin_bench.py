"""Measures in cocotb the delay of an edge from head 1's pins to the output's pins of the core."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import cocotb
from cocotb.triggers import ClockCycles, FallingEdge

from tb.registers.axi_lite import start

FOLD, HEADS = int(os.environ["FOLD"]), int(os.environ["HEADS"])
MEASURED = Path(os.environ["MEASURED"])
LEVELS = ((0, 0), (1, 0), (1, 1), (0, 1))
"""Levels (A, B) in counting order."""
BETWEEN_CLOCKS = 97
"""Number of clocks between edges. It is odd, so that edges occur in each of the FOLD slots."""


def _outputs(dut: Any) -> tuple[int, int]:
    return int(dut.out_a.value), int(dut.out_b.value)


@cocotb.test()
async def from_pin_to_pin(dut: Any) -> None:
    """Store the numbers of rising clock edges from an edge at head 1's pins to the output's edge,
    and the latency that the register states.

    The pin changes half a clock before the first counted edge.
    """
    for head in range(1, HEADS + 1):
        for pin in "abz":
            getattr(dut, f"head{head}_{pin}").value = 0
    bus = await start(dut, reset_clocks=64)
    registers = bus.registers()
    await registers.write("output_spacing", 1)
    await registers.update("control", output_enable=1)
    await ClockCycles(dut.clock, 200)
    seen = set()
    for edge in range(1, 3 * FOLD + 1):
        await FallingEdge(dut.clock)
        before = _outputs(dut)
        dut.head1_a.value, dut.head1_b.value = LEVELS[edge % 4]
        clocks = 0
        while _outputs(dut) == before:
            await FallingEdge(dut.clock)
            clocks += 1
            assert clocks < BETWEEN_CLOCKS, "the edge did not come out"
        seen.add(clocks)
        await ClockCycles(dut.clock, BETWEEN_CLOCKS - clocks)
    stated = await registers.read("pipeline.latency")
    found = {"from_pin_to_pin": sorted(seen), "register_latency": stated}
    MEASURED.write_text(json.dumps(found), encoding="utf-8")
