"""Compares table_rotation with its model in cocotb tests, for all 2**17 values of its used bits."""

from __future__ import annotations

from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from arctrue.gateware.table_rotation import (
    DIGITS_WIDTH,
    OFFSET_WIDTH,
    table_rotation,
)
from arctrue.generated.number_formats import CORDIC_ITERATIONS, COSINE_ADDRESS_WIDTH

LATENCY = CORDIC_ITERATIONS - 1
"""Latency in clocks, equal to that of cordic_rotation."""

UNUSED_WIDTH = OFFSET_WIDTH - DIGITS_WIDTH


@cocotb.test()
async def every_place(dut: Any) -> None:
    """The outputs equal the model's for all 2**17 values of the used bits, in random order, one per
    clock; the unused low bits are random."""
    random = np.random.default_rng(5)
    places = random.permutation(1 << (COSINE_ADDRESS_WIDTH + DIGITS_WIDTH)).astype(np.int32)
    angles = (places << UNUSED_WIDTH) + random.integers(0, 1 << UNUSED_WIDTH, places.size)
    angles = angles.astype(np.int32)
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await FallingEdge(dut.clock)
    seen = []
    for angle in [*angles.tolist(), *[0] * LATENCY]:
        dut.folded.value = angle
        await FallingEdge(dut.clock)
        seen.append(dut.cosine.value)
    found = np.array([word.to_signed() for word in seen[LATENCY - 1 : LATENCY - 1 + angles.size]])
    wrong = np.flatnonzero(found != table_rotation(angles))
    assert not wrong.size, (
        f"folded {angles[wrong[0]]}: {found[wrong[0]]}, expected "
        f"{table_rotation(angles)[wrong[0]]} ({wrong.size} of {angles.size} differ)"
    )


@cocotb.test()
async def latency(dut: Any) -> None:
    """A step of the angle appears at the output after 15 clocks, not after 14."""
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.folded.value = 0
    for _ in range(LATENCY + 2):
        await RisingEdge(dut.clock)
    await FallingEdge(dut.clock)
    before = dut.cosine.value
    dut.folded.value = (1 << 22) - 1
    for _ in range(LATENCY - 1):
        await FallingEdge(dut.clock)
        assert dut.cosine.value == before
    await FallingEdge(dut.clock)
    assert dut.cosine.value != before
