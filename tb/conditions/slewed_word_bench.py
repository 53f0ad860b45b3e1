"""Compares the entity slewed_word with its model in a cocotb test."""

from __future__ import annotations

import random
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.table_conditions import MODULATOR_ONE, slewed


@cocotb.test()
async def every_step_as_the_model(dut: Any) -> None:
    generator = random.Random(32)
    dut.reset.value = 1
    dut.step.value = 0
    dut.slew.value = 0
    dut.target.value = 0
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(3):
        await RisingEdge(dut.clock)
    dut.reset.value = 0
    fine = 0
    for _ in range(2000):
        if generator.random() < 0.05:
            dut.target.value = generator.randint(-MODULATOR_ONE, MODULATOR_ONE)
            dut.slew.value = generator.choice([0, 1, 65536, 1 << 26, (1 << 32) - 1])
        dut.step.value = 1
        await RisingEdge(dut.clock)
        dut.step.value = 0
        fine = slewed(fine, dut.target.value.to_signed(), int(dut.slew.value))
        await RisingEdge(dut.clock)
        assert dut.word.value.to_signed() == fine >> 16
        assert dut.reached.value == (fine == dut.target.value.to_signed() << 16)
