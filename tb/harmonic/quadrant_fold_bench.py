"""Compares quadrant_fold with its model in cocotb tests."""

from __future__ import annotations

from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.quadrant_fold import quadrant_fold
from tb.harmonic.phases import phases


@cocotb.test()
async def every_quadrant(dut: Any) -> None:
    """In every quadrant, one clock after the phase, the outputs `folded` and `negative` equal the
    model; so does the folded phase that the outputs `place` and `mirrored` describe."""
    given = phases(4000)
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    dut.phase.value = 0
    await RisingEdge(dut.clock)
    seen = []
    for phase in [*given.tolist(), 0]:
        dut.phase.value = phase
        await RisingEdge(dut.clock)
        place = dut.place.value.to_unsigned()
        mirrored = 2**22 - 1 - place if dut.mirrored.value == 1 else place
        seen.append((dut.folded.value.to_unsigned(), -int(dut.negative.value), mirrored))
    model = quadrant_fold(given)
    expected = np.column_stack([model.folded, model.negative, model.folded])
    wrong = np.flatnonzero((np.array(seen[1:]) != expected).any(axis=1))
    assert not wrong.size, f"phase {given[wrong[0]]}: {seen[1 + wrong[0]]}, {wrong.size} differ"
