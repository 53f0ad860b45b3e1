"""Plays the edges of both heads and records the decoders' outputs every EVERY_CLOCKS clocks."""

from __future__ import annotations

import os
from pathlib import Path

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.handle import HierarchyObject
from cocotb.triggers import ClockCycles, FallingEdge

EVERY_CLOCKS = 41


@cocotb.test()
async def note_positions(dut: HierarchyObject) -> None:
    dut.run.value = 0
    dut.reset.value = 1
    Clock(dut.clock, 10, unit="ns").start()
    await ClockCycles(dut.clock, 10)
    dut.reset.value = 0
    await ClockCycles(dut.clock, 10)
    await FallingEdge(dut.clock)
    dut.run.value = 1
    # The player counts the next rising edge as clock 1: this falling edge is in clock 0.
    clock = 0
    noted = []
    while dut.played_out.value == 0:
        await ClockCycles(dut.clock, EVERY_CLOCKS, FallingEdge)
        clock += EVERY_CLOCKS
        seen = dut.index_seen.value
        noted.append(
            [
                clock,
                dut.head1_turn_position.value.to_signed(),
                dut.head2_turn_position.value.to_signed(),
                dut.head1_angle.value.to_unsigned(),
                dut.head2_angle.value.to_unsigned(),
                int(seen) & 1,
                int(seen) >> 1,
            ]
        )
    assert int(dut.faults.value) == 0, f"index errors or illegal transitions: {dut.faults.value}"
    np.save(Path(os.environ["ARCTRUE_NOTED"]), np.array(noted))
