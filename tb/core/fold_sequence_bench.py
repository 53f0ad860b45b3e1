"""Tests in cocotb that fold_sequence outputs its slot and its strobes in the right clocks."""

from __future__ import annotations

import os
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

FOLD = int(os.environ["FOLD"])
SUMS_CLOCK = int(os.environ["SUMS_CLOCK"])


@cocotb.test()
async def strobes_belong_to_their_angles(dut: Any) -> None:
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    await RisingEdge(dut.clock)
    seen = []
    for _ in range(200):
        await RisingEdge(dut.clock)
        seen.append(
            (
                dut.slot.value.to_unsigned(),
                int(dut.accept.value),
                int(dut.last_slot.value),
                int(dut.first_sums.value),
                int(dut.last_sums.value),
            )
        )
    accepted = [clock for clock, entry in enumerate(seen) if entry[1]]
    assert accepted == list(range(accepted[0], len(seen), FOLD))
    first = {clock + SUMS_CLOCK for clock in accepted}
    last = {clock + SUMS_CLOCK + FOLD - 1 for clock in accepted}
    for clock, entry in enumerate(seen):
        slot = (clock - accepted[0]) % FOLD
        assert entry[0] == slot
        assert entry[2] == int(slot == FOLD - 1)
        if clock >= accepted[0] + SUMS_CLOCK + FOLD:
            assert entry[3:] == (int(clock in first), int(clock in last)), f"clock {clock}"
