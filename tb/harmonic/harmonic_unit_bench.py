"""Compares harmonic_unit with its model in cocotb tests."""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.harmonic_unit import harmonic_unit
from arctrue.generated.number_formats import (
    AMPLITUDE_CLOCK,
    AMPLITUDE_WIDTH,
    HARMONIC_LATENCY,
    PAIR_FRACTION,
    PAIR_WIDTH,
    PHASE_WIDTH,
)
from tb.harmonic.harmonic_generics import CORDIC_ITERATIONS, COSINE_WIDTH, ROTATION
from tb.support.flat import flat, signed_words

LANES = int(os.environ.get("LANES", "32"))
ANGLES = int(os.environ.get("ANGLES", "300"))
PAIRS = (LANES + 1) // 2
AMPLITUDE_AFTER = CORDIC_ITERATIONS
LATENCY = CORDIC_ITERATIONS + 4
LARGEST = 2 ** (AMPLITUDE_WIDTH - 1)


def pairs(dut: Any) -> list[int]:
    return signed_words(dut.pair_sums.value.to_unsigned(), PAIRS, PAIR_WIDTH)


@cocotb.test()
async def pair_sums(dut: Any) -> None:
    """Pair sums equal the model's while phases and amplitudes of every lane change in every
    clock."""
    rng = np.random.default_rng(LANES)
    phases = rng.integers(0, 2**PHASE_WIDTH, (ANGLES, LANES), dtype=np.int32)
    amplitudes = rng.integers(-LARGEST, LARGEST, (ANGLES, LANES))
    # These inputs give the largest possible sums of both signs.
    phases[:4] = 0
    amplitudes[:2] = -LARGEST
    amplitudes[2:4] = LARGEST - 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    seen = []
    for clock in range(ANGLES + LATENCY):
        dut.phases.value = flat(phases[min(clock, ANGLES - 1)], PHASE_WIDTH)
        dut.amplitudes.value = flat(
            amplitudes[min(max(clock - AMPLITUDE_AFTER, 0), ANGLES - 1)], AMPLITUDE_WIDTH
        )
        await RisingEdge(dut.clock)
        seen.append(dut.pair_sums.value)
    found = np.array(
        [signed_words(value.to_unsigned(), PAIRS, PAIR_WIDTH) for value in seen[LATENCY:]]
    )
    expected = harmonic_unit(phases, amplitudes, COSINE_WIDTH, CORDIC_ITERATIONS, ROTATION)
    wrong = np.argwhere(found != expected)
    assert not wrong.size, f"first at angle and pair {wrong[0]}, {len(wrong)} differ"


@cocotb.test()
async def latency(dut: Any) -> None:
    """At the ports, pair sums come CORDIC_ITERATIONS + 4 clocks (20 by default) after their phases;
    amplitudes are read CORDIC_ITERATIONS clocks (16 by default) after the phases."""
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    unit = 1 << 11
    dut.phases.value = flat(np.zeros(LANES, dtype=np.int64), PHASE_WIDTH)
    dut.amplitudes.value = flat(np.full(LANES, unit), AMPLITUDE_WIDTH)
    for _ in range(LATENCY + 5):
        await RisingEdge(dut.clock)
    both = np.full(PAIRS, 2)
    both[-1] -= LANES % 2
    one = 1 << PAIR_FRACTION
    assert np.abs(pairs(dut) - both * one).max() < one * 2.0 ** -(COSINE_WIDTH - 4)
    for port, word, width, expected in (
        ("phases", 1 << (PHASE_WIDTH - 1), PHASE_WIDTH, LATENCY),
        ("amplitudes", 2 * unit, AMPLITUDE_WIDTH, LATENCY - AMPLITUDE_AFTER),
    ):
        before = pairs(dut)
        getattr(dut, port).value = flat(np.full(LANES, word), width)
        changed = [0] * PAIRS
        for clocks in range(LATENCY + 5):
            await RisingEdge(dut.clock)
            now = pairs(dut)
            for pair in range(PAIRS):
                if now[pair] != before[pair] and not changed[pair]:
                    changed[pair] = clocks
        assert changed == [expected] * PAIRS, f"{port}: {changed} clocks, expected {expected}"
    if CORDIC_ITERATIONS == 16:
        assert LATENCY == HARMONIC_LATENCY == 20
        assert AMPLITUDE_AFTER == AMPLITUDE_CLOCK
