"""Compares the VHDL input synchroniser with its model."""

from __future__ import annotations

import os

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from arctrue.gateware.input_synchroniser import input_synchroniser

WIDTH = int(os.environ["WIDTH"])
STAGES = int(os.environ["STAGES"])


@cocotb.test()
async def delays_every_pin_by_its_stages(dut) -> None:
    levels = np.random.default_rng(1).integers(2**WIDTH, size=500)
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await FallingEdge(dut.clock)
    got = []
    for word in levels.tolist():
        # The first STAGES outputs are the initial zeros of the registers.
        got.append(int(dut.synchronised.value))
        dut.asynchronous.value = word
        await FallingEdge(dut.clock)
    assert got[STAGES:] == input_synchroniser(levels, STAGES)[STAGES:].tolist()
    assert got[STAGES:] == levels[:-STAGES].tolist()
