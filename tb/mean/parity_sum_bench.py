"""Tests in cocotb that parity and `beyond` of parity_sum equal the model's in every bit."""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.parity_sum import parity_sum
from arctrue.generated.number_formats import HEAD_DIFFERENCE_WIDTH, HEAD_WEIGHT_WIDTH
from tb.support.flat import flat

HEADS = int(os.environ.get("HEADS", "4"))


@cocotb.test()
async def equals_the_model(dut: Any) -> None:
    """The parity equals the model's for random weights, with differences that are random or at the
    ends of their format; the inputs are held for at least two calculations of the parity."""
    rng = np.random.default_rng(HEADS)
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    over = 0
    for case in range(400):
        # With Σ c = 0 and |c| < 2 every parity fits its format.
        half = 1 << (HEAD_WEIGHT_WIDTH - 2)
        weights = rng.integers(-half // 2, half // 2, HEADS)
        weights[-1] = -weights[:-1].sum()
        reach = 1 << (HEAD_DIFFERENCE_WIDTH - 1)
        differences = rng.integers(-reach, reach, HEADS)
        if case % 10 == 0:
            differences = rng.choice([-reach, reach - 1], HEADS)
        if case % 3 == 0:
            differences //= 4096
        limit = int(rng.choice([0, 10, 200]))
        dut.differences.value = flat(differences, HEAD_DIFFERENCE_WIDTH)
        dut.weights.value = flat(weights, HEAD_WEIGHT_WIDTH)
        dut.limit.value = limit
        for _ in range(24):
            await RisingEdge(dut.clock)
        expected = int(parity_sum(differences, weights))
        assert dut.parity.value.to_signed() == expected, f"case {case}"
        beyond = bool(limit) and abs(expected >> 11) >= limit
        assert bool(dut.beyond.value) == beyond, f"case {case}"
        over += beyond
    assert 20 < over < 380
