"""Drives all inputs of an entity from a file, clock by clock, and records all outputs."""

from __future__ import annotations

import json
import os
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge


@cocotb.test()
async def play_and_note(dut) -> None:
    folder = Path(os.environ["ARCTRUE_EQUAL_FOLDER"])
    inputs = json.loads((folder / "inputs.json").read_text(encoding="utf-8"))
    names = json.loads((folder / "outputs.json").read_text(encoding="utf-8"))
    drivers = [(getattr(dut, name), values) for name, values in inputs.items()]
    outputs = [getattr(dut, name) for name in names]
    last: list[int | None] = [None] * len(drivers)
    rows: list[list[str]] = []
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await FallingEdge(dut.clock)
    for clock in range(len(drivers[0][1])):
        for place, (driver, values) in enumerate(drivers):
            if values[clock] != last[place]:
                last[place] = values[clock]
                driver.value = values[clock]
        await FallingEdge(dut.clock)
        rows.append([str(output.value) for output in outputs])
    columns = dict(zip(names, (list(column) for column in zip(*rows, strict=True)), strict=True))
    (folder / "noted.json").write_text(json.dumps(columns), encoding="utf-8")
