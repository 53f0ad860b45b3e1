"""Tests delay_line in cocotb with random words, one in each clock."""

from __future__ import annotations

import os
import random
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.delay_line import delay_line

WIDTH = int(os.environ.get("WIDTH", "58"))
CLOCKS = int(os.environ.get("CLOCKS", "25"))


@cocotb.test()
async def every_word_comes_out_once(dut: Any) -> None:
    """The output is the input of CLOCKS clocks earlier, and 0 until the first word arrives."""
    rng = random.Random(1)
    words = [rng.getrandbits(WIDTH) for _ in range(300)]
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    dut.undelayed.value = 0
    await RisingEdge(dut.clock)
    seen = []
    for word in words:
        dut.undelayed.value = word
        await RisingEdge(dut.clock)
        seen.append(dut.delayed.value.to_unsigned())
    assert seen == [0] * CLOCKS + words[: 300 - CLOCKS]
    assert seen == delay_line(np.array(words, dtype=np.uint64), CLOCKS).tolist()
