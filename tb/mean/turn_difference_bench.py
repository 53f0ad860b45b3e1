"""Compares turn_difference with its model, and checks its definition, in cocotb tests."""

from __future__ import annotations

import itertools
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from numpy.typing import NDArray

from arctrue.gateware.turn_difference import turn_difference
from arctrue.generated.number_formats import DIFFERENCE_LATENCY


async def differences(
    dut: Any, minuend: NDArray[np.int64], subtrahend: NDArray[np.int64], counts_per_rev: int
) -> NDArray[np.int64]:
    """Drive a new pair of angles in each clock; return the difference of each pair."""
    dut.counts_per_rev.value = counts_per_rev
    seen = []
    last = minuend.size - 1
    for clock in range(minuend.size + DIFFERENCE_LATENCY):
        dut.minuend.value = int(minuend[min(clock, last)])
        dut.subtrahend.value = int(subtrahend[min(clock, last)])
        await RisingEdge(dut.clock)
        seen.append(dut.difference.value)
    return np.array([value.to_signed() for value in seen[DIFFERENCE_LATENCY:]])


async def start(dut: Any) -> None:
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    await RisingEdge(dut.clock)


@cocotb.test()
async def every_pair_of_small_turns(dut: Any) -> None:
    """For all pairs of angles in turns of 4 to 11 counts, the difference is right modulo the turn
    and in the shorter direction."""
    await start(dut)
    for counts_per_rev in range(4, 12):
        pairs = np.array(list(itertools.product(range(counts_per_rev), repeat=2))).T
        found = await differences(dut, pairs[0], pairs[1], counts_per_rev)
        assert not ((found - pairs[0] + pairs[1]) % counts_per_rev).any()
        assert (-counts_per_rev <= 2 * found).all()
        assert (2 * found < counts_per_rev).all()


@cocotb.test()
async def borders_and_random_pairs(dut: Any) -> None:
    await start(dut)
    rng = np.random.default_rng(27)
    for counts_per_rev in (4, 5, 1000, 2**24 - 1, 2**24):
        half = counts_per_rev // 2
        edges = {0, 1, half - 1, half, half + 1, counts_per_rev - 2, counts_per_rev - 1}
        pairs = np.array(list(itertools.product(sorted(edges), repeat=2)))
        pairs = np.concatenate([pairs, rng.integers(0, counts_per_rev, (2000, 2))]).T
        found = await differences(dut, pairs[0], pairs[1], counts_per_rev)
        assert np.array_equal(found, turn_difference(pairs[0], pairs[1], counts_per_rev))
