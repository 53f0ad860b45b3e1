"""Compares weighted_mean with its model in cocotb tests."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from numpy.typing import NDArray

from arctrue.gateware.mean_set import WEIGHT_LIMIT, WEIGHT_ONE, MeanSet
from arctrue.gateware.weighted_mean import weighted_mean
from arctrue.generated.number_formats import (
    ANGLE_WIDTH,
    HEAD_OFFSET_FRACTION,
    HEAD_WEIGHT_WIDTH,
    MEAN_LATENCY,
)
from tb.support.flat import flat

HEADS = int(os.environ.get("HEADS", "2"))
WIDEST = WEIGHT_LIMIT - 1


def sets(rng: np.random.Generator) -> Iterator[MeanSet]:
    """Yield means with equal weights, with head 1 alone, with the largest weights of either sign,
    and with random weights for all heads except one."""
    equal = [WEIGHT_ONE // HEADS] * HEADS
    equal[0] += WEIGHT_ONE - sum(equal)
    yield MeanSet(tuple(equal), (0,) * HEADS)
    yield MeanSet((WEIGHT_ONE, *(0,) * (HEADS - 1)), (15,) + (1,) * (HEADS - 1))
    for carrier in range(1, HEADS + 1):
        offsets = tuple(rng.integers(0, 4 << HEAD_OFFSET_FRACTION, HEADS).tolist())
        weights = [0] * HEADS
        weights[carrier - 1] = WEIGHT_ONE - WIDEST
        weights[carrier % HEADS] = WIDEST
        yield MeanSet(tuple(weights), offsets, carrier)
        missing = carrier % HEADS + 1
        random = rng.integers(-WIDEST // 3, WIDEST // 3, HEADS)
        random[missing - 1] = 0
        random[carrier - 1] = 0
        random[carrier - 1] = WEIGHT_ONE - random.sum()
        if abs(int(random[carrier - 1])) < WIDEST:
            yield MeanSet(tuple(random.tolist()), offsets, carrier, missing)


def some_readings(rng: np.random.Generator, counts_per_rev: int) -> NDArray[np.int64]:
    """Return readings of heads that nearly agree, around the zero, readings with differences near
    the limit or half a turn, and readings at random angles."""
    true = rng.integers(-40, 40, 150)
    near = rng.integers(-300, 300, (150, HEADS)) + true[:, np.newaxis]
    limits = [65_535, 65_536, 65_537, counts_per_rev // 2]
    edges = list(itertools.product((0, *limits, *(-limit for limit in limits)), repeat=2))
    pairs = np.zeros((len(edges), HEADS), dtype=np.int64)
    pairs[:, :2] = edges
    pairs[:, 2:] = pairs[:, 1:2]
    anywhere = rng.integers(0, counts_per_rev, (100, HEADS))
    return np.concatenate([near, pairs, anywhere]) % counts_per_rev


def drive(dut: Any, readings: NDArray[np.int64], mean: MeanSet) -> None:
    """Drive the readings of one clock, (heads,), and the parameters of the mean for these
    readings."""
    fractions = np.array(mean.offsets) % (1 << HEAD_OFFSET_FRACTION)
    dut.readings.value = flat(readings, ANGLE_WIDTH)
    dut.carrier_reading.value = int(readings[mean.carrier - 1])
    dut.fractions.value = flat(fractions, HEAD_OFFSET_FRACTION)
    dut.carrier_fraction.value = int(fractions[mean.carrier - 1])
    dut.weights.value = flat(np.array(mean.weights), HEAD_WEIGHT_WIDTH)
    dut.used.value = sum(1 << head for head, used in enumerate(mean.used) if used)


async def compare(dut: Any, readings: NDArray[np.int64], means: list[MeanSet], counts: int) -> None:
    """Compare the outputs with the model's; the readings, and the words if ``means`` differ, change
    in every clock."""
    dut.counts_per_rev.value = counts
    seen = []
    last = len(readings) - 1
    for clock in range(len(readings) + MEAN_LATENCY):
        drive(dut, readings[min(clock, last)], means[min(clock, last)])
        await RisingEdge(dut.clock)
        seen.append((dut.mean_term.value, dut.limited.value))
    for row, mean, (term, limited) in zip(readings, means, seen[MEAN_LATENCY:], strict=True):
        expected = weighted_mean(row[np.newaxis], mean, counts)
        assert term.to_signed() == expected.term[0], (row, mean)
        assert bool(limited) == expected.limited[0], (row, mean)


@cocotb.test()
async def terms_equal_the_model(dut: Any) -> None:
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    await RisingEdge(dut.clock)
    rng = np.random.default_rng(HEADS)
    for counts_per_rev in (4096, 1_000_003, 2**24):
        for mean in sets(rng):
            readings = some_readings(rng, counts_per_rev)
            await compare(dut, readings, [mean] * len(readings), counts_per_rev)


@cocotb.test()
async def words_belong_to_their_readings(dut: Any) -> None:
    """Each output is computed with the words that came with its readings, although the words change
    in every clock."""
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    await RisingEdge(dut.clock)
    rng = np.random.default_rng(10 + HEADS)
    some = list(sets(rng))
    readings = rng.integers(-1000, 1000, (400, HEADS)) % 2**20
    chosen = [some[index] for index in rng.integers(0, len(some), 400)]
    await compare(dut, readings, chosen, 2**20)
