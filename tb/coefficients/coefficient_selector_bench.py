"""cocotb test of coefficient_selector: which block of lanes each slot meets."""

from __future__ import annotations

import os
import random
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge, Timer

LANES = int(os.environ["LANES"])
FOLD = int(os.environ["FOLD"])
WIDTH = int(os.environ["WIDTH"])
CLOCKS = int(os.environ["CLOCKS"])


@cocotb.test()
async def blocks_come_in_turn(dut: Any) -> None:
    """Slot s of an angle meets block s, CLOCKS + s clocks after the angle; the words may change."""
    rng = random.Random(LANES)
    block_bits = LANES // FOLD * WIDTH
    dut.slot.value = 0
    dut.words.value = 0
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    await RisingEdge(dut.clock)
    for clock in range(200):
        words = rng.getrandbits(LANES * WIDTH)
        dut.slot.value = clock % FOLD
        dut.words.value = words
        await Timer(1, "ns")
        if clock:
            block = (clock - CLOCKS) % FOLD
            expected = words >> (block * block_bits) & (2**block_bits - 1)
            assert dut.selected.value.to_unsigned() == expected, f"clock {clock}: not block {block}"
        await RisingEdge(dut.clock)
