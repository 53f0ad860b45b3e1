"""Compares harmonic_lane with its model in cocotb tests."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from numpy.typing import NDArray

from arctrue.gateware.harmonic_lane import harmonic_lane, lane_cosine
from arctrue.generated.number_formats import AMPLITUDE_CLOCK, AMPLITUDE_WIDTH
from tb.harmonic.harmonic_generics import CORDIC_ITERATIONS, COSINE_WIDTH, ROTATION
from tb.harmonic.phases import phases

ANGLES = int(os.environ.get("ANGLES", "20000"))
ADD_PARTNER = os.environ.get("ADD_PARTNER", "false") == "true"
AMPLITUDE_AFTER = CORDIC_ITERATIONS
PARTNER_AFTER = CORDIC_ITERATIONS + 3
LATENCY = PARTNER_AFTER + int(ADD_PARTNER)
LARGEST = 2 ** (AMPLITUDE_WIDTH - 1)


async def run(
    dut: Any,
    phase: NDArray[np.int32],
    amplitude: NDArray[np.int64],
    partner: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Drive one phase in each clock, and its amplitude and partner as many clocks later as the
    pipeline needs; return the products."""
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    last = phase.size - 1
    seen = []
    for clock in range(phase.size + LATENCY):
        dut.phase.value = int(phase[min(clock, last)])
        dut.amplitude.value = int(amplitude[min(max(clock - AMPLITUDE_AFTER, 0), last)])
        dut.partner.value = int(partner[min(max(clock - PARTNER_AFTER, 0), last)])
        await RisingEdge(dut.clock)
        seen.append(dut.product.value)
    return np.array([word.to_signed() for word in seen[LATENCY:]], dtype=np.int64)


def compare(found: NDArray[np.int64], expected: NDArray[np.int64]) -> None:
    wrong = np.flatnonzero(found != expected)
    assert not wrong.size, (
        f"phase number {wrong[0]}: {found[wrong[0]]}, expected {expected[wrong[0]]} "
        f"({wrong.size} of {found.size} differ)"
    )


@cocotb.test()
async def products(dut: Any) -> None:
    """Products equal the model's, with amplitudes up to the ends of s13.11; a lane with ADD_PARTNER
    adds the partner's product."""
    rng = np.random.default_rng(3)
    phase = phases(ANGLES)
    amplitude = rng.integers(-LARGEST, LARGEST, phase.size)
    # A quarter of the amplitudes lie at the ends of s13.11; their phases include those with the
    # largest cosine.
    amplitude[: phase.size // 4 : 2] = -LARGEST
    amplitude[1 : phase.size // 4 : 2] = LARGEST - 1
    partner = harmonic_lane(
        np.roll(phase, 1),
        np.roll(amplitude, 2),
        COSINE_WIDTH,
        CORDIC_ITERATIONS,
        rotation=ROTATION,
    )
    found = await run(dut, phase, amplitude, partner)
    compare(
        found,
        harmonic_lane(
            phase,
            amplitude,
            COSINE_WIDTH,
            CORDIC_ITERATIONS,
            partner if ADD_PARTNER else 0,
            ROTATION,
        ),
    )


@cocotb.test()
async def cosines(dut: Any) -> None:
    """With an amplitude of one unit the product equals the cosine; the test stores the cosines for
    a picture."""
    phase = phases(ANGLES, seed=4)
    found = await run(
        dut,
        phase,
        np.ones(phase.size, dtype=np.int64),
        np.zeros(phase.size, dtype=np.int64),
    )
    compare(found, lane_cosine(phase, COSINE_WIDTH, CORDIC_ITERATIONS, ROTATION).astype(np.int64))
    if file := os.environ.get("COSINES_FILE"):
        np.savez(Path(file), phase=phase, cosine=found.astype(np.int32))


@cocotb.test()
async def latency(dut: Any) -> None:
    """With 16 iterations, the product comes 19 clocks after its phase (20 with a partner), and the
    lane reads the amplitude 16 clocks after the phase."""
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    dut.phase.value = 0
    dut.amplitude.value = 1000
    dut.partner.value = 0
    for _ in range(LATENCY + 5):
        await RisingEdge(dut.clock)
    for name, value, expected in (
        ("phase", 1 << 21, LATENCY),
        ("amplitude", 2000, LATENCY - AMPLITUDE_AFTER),
        ("partner", 77, LATENCY - PARTNER_AFTER if ADD_PARTNER else None),
    ):
        before = dut.product.value
        getattr(dut, name).value = value
        clocks = 0
        await RisingEdge(dut.clock)
        while dut.product.value == before and clocks < 40:
            clocks += 1
            await RisingEdge(dut.clock)
        if expected is not None:
            assert clocks == expected, f"{name}: {clocks} clocks, expected {expected}"
        else:
            assert clocks == 40, f"{name} had an effect"
    if CORDIC_ITERATIONS == 16:
        assert (20 if ADD_PARTNER else 19) == LATENCY
        assert AMPLITUDE_AFTER == AMPLITUDE_CLOCK
