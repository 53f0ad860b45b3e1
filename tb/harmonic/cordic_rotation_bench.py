"""Compares cordic_rotation with its model in a cocotb test, with one angle in each clock."""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.cordic_rotation import cordic_rotation
from tb.harmonic.harmonic_generics import CORDIC_ITERATIONS, COSINE_WIDTH

ANGLES = int(os.environ.get("ANGLES", "20000"))
QUARTER = 1 << 22
# The latency is one clock for each iteration, except iteration 0.
LATENCY = CORDIC_ITERATIONS - 1


@cocotb.test()
async def equals_the_model(dut: Any) -> None:
    """The outputs equal the model's at both ends of the first quadrant, for evenly spread angles,
    and for random angles; some angles are mirrored."""
    rng = np.random.default_rng(2)
    ends = np.concatenate(
        [np.arange(64), QUARTER // 2 + np.arange(-32, 32), QUARTER - 1 - np.arange(64)]
    )
    even = np.linspace(0, QUARTER - 1, ANGLES // 2).astype(np.int64)
    some = rng.integers(0, QUARTER, max(0, ANGLES - ends.size - even.size))
    angles = np.concatenate([ends, even, some]).astype(np.int32)
    assert angles.size >= ANGLES
    mirrors = rng.integers(0, 2, angles.size + LATENCY, dtype=bool)
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    dut.place.value, dut.mirrored.value = 0, 0
    for _ in range(LATENCY):
        await RisingEdge(dut.clock)
    seen = []
    for angle, mirror in zip([*angles.tolist(), *[0] * LATENCY], mirrors, strict=True):
        dut.place.value = QUARTER - 1 - angle if mirror else angle
        dut.mirrored.value = int(mirror)
        await RisingEdge(dut.clock)
        seen.append(dut.cosine.value.to_signed())
    found = np.array(seen[LATENCY:])
    expected = cordic_rotation(angles, COSINE_WIDTH, CORDIC_ITERATIONS)
    wrong = np.flatnonzero(found != expected)
    assert not wrong.size, (
        f"angle {angles[wrong[0]]}: {found[wrong[0]]}, expected {expected[wrong[0]]} "
        f"({wrong.size} of {angles.size} differ)"
    )
    # Check that the angles select all 2⁶ constants of the first seven iterations.
    assert np.unique(angles >> 13).size == QUARTER >> 13 or ANGLES < 20_000
