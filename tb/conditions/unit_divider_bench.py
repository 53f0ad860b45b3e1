"""Compares unit_divider with Python's division of integers in cocotb tests."""

from __future__ import annotations

import random
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.table_conditions import unit_quotient


@cocotb.test()
async def quotients(dut: Any) -> None:
    generator = random.Random(31)
    dut.reset.value = 1
    dut.start.value = 0
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    await RisingEdge(dut.clock)
    dut.reset.value = 0
    pairs = [(0, 0), (5, 0), (0, 5), (5, 5), (6, 5), (2**56 - 1, 1), (2**56 - 2, 2**56 - 1)]
    pairs += [(1, 2**17), (1, 2**17 + 1), (131_071, 131_072)]
    for _ in range(400):
        size = 1 << generator.randint(1, 56)
        divisor = generator.randrange(size)
        pairs.append((generator.randrange(divisor + divisor // 8 + 2), divisor))
    for dividend, divisor in pairs:
        dut.dividend.value, dut.divisor.value = dividend % 2**56, divisor
        dut.start.value = 1
        await RisingEdge(dut.clock)
        dut.start.value = 0
        done = []
        for _ in range(20):
            await RisingEdge(dut.clock)
            done.append(bool(dut.done.value))
        assert done == [False] * 18 + [True, False], "19 clocks after the clock of start"
        assert int(dut.quotient.value) == unit_quotient(dividend % 2**56, divisor)
