"""Measures the latency of each unit of the compensation from a step of the angle."""

from __future__ import annotations

import json
import os
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.handle import HierarchyObject
from cocotb.triggers import ClockCycles, FallingEdge

from arctrue.studies.demo.files import DemoFiles

OUTPUTS = ("phases", "pair_sums", "delayed_angle", "corrected_angle")
# The angle steps from 1/8 to 3/8 of a turn, by which every output changes.
BEFORE, AFTER = 1 << 21, 3 << 21
# Number of clocks within which the ramp from zero to the first correction ends.
SETTLE_CLOCKS = 12_000


@cocotb.test()
async def step(dut: HierarchyObject) -> None:
    dut.angle.value = BEFORE
    dut.reset.value = 1
    Clock(dut.clock, 10, unit="ns").start()
    await ClockCycles(dut.clock, 10)
    dut.reset.value = 0
    await ClockCycles(dut.clock, SETTLE_CLOCKS)
    await FallingEdge(dut.clock)
    settled = {name: getattr(dut, name).value for name in OUTPUTS}
    dut.angle.value = AFTER
    answered: dict[str, int] = {}
    for clocks in range(1, 64):
        await FallingEdge(dut.clock)
        for name in OUTPUTS:
            if name not in answered and getattr(dut, name).value != settled[name]:
                answered[name] = clocks
    assert set(answered) == set(OUTPUTS), f"no answer from {set(OUTPUTS) - set(answered)}"
    measured = {
        "phase calculation": answered["phases"],
        "harmonic calculation": answered["pair_sums"] - answered["phases"],
        "error compensation": answered["corrected_angle"] - answered["pair_sums"],
        "delay line": answered["delayed_angle"],
    }
    files = DemoFiles(Path(os.environ["ARCTRUE_DEMO_FOLDER"]))
    files.latency.write_text(json.dumps(measured, indent=1), encoding="utf-8")
