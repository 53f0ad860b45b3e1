"""Decodes the signals of encoder_source; compares the counts with a float64 calculation."""

from __future__ import annotations

import os

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge
from numpy.typing import NDArray

COUNTS_PER_REV = 1024
COUNTS_PER_SECOND = 40_000_000
STEP = round(COUNTS_PER_SECOND / 125_000_000 * 2**24) / 2**24
SEPARATION = 94
AHEAD = (0, SEPARATION, 503, 734)
"""Counts by which the reading of each head exceeds that of head 1."""
HEADS = int(os.environ.get("HEADS", "2"))
AMPLITUDES = (9, 4)
TURNS = (0.334, 0.668)
LATENCY = 35
CLOCKS = 7_800
"""Number of clocks: two turns of 3,200 clocks, plus the time before the first index."""

BOUND_COUNTS = 1.6
"""Largest permitted deviation in counts: 1 for the truncation of the true angle, 0.5 for the
rounding of the reading, and 0.1 for the rounding of the coefficients."""

LEVELS = {(0, 0): 0, (1, 0): 1, (1, 1): 2, (0, 1): 3}


def decoded(a: NDArray[np.int64], b: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the count in every clock, decoded from A and B by the paper's figure 4; it starts at
    0."""
    code = np.array([LEVELS[pair] for pair in zip(a.tolist(), b.tolist(), strict=True)])
    steps = (np.diff(code) + 1) % 4 - 1
    assert np.all(np.abs(steps) <= 1), "A and B changed together"
    return np.concatenate([[0], np.cumsum(steps)])


def expected(true_counts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the reading R = θ + ε(θ) of equation (2) in counts; ``true_counts`` is θ."""
    turn = true_counts / COUNTS_PER_REV
    error = sum(
        amplitude * np.cos(2 * np.pi * (order * turn + phase))
        for order, (amplitude, phase) in enumerate(zip(AMPLITUDES, TURNS, strict=True), start=1)
    )
    return np.asarray(true_counts + error)


@cocotb.test()
async def all_heads_show_one_disc(dut: object) -> None:
    clock = dut.clock  # type: ignore[attr-defined]
    cocotb.start_soon(Clock(clock, 8, unit="ns").start())
    dut.reset.value = 1  # type: ignore[attr-defined]
    for _ in range(4):
        await FallingEdge(clock)
    dut.reset.value = 0  # type: ignore[attr-defined]
    pins = {name: np.zeros(CLOCKS, dtype=np.int64) for name in ("a", "b", "z")}
    heads = {head: {k: v.copy() for k, v in pins.items()} for head in (1, 2, 3, 4)}
    for number in range(CLOCKS):
        await FallingEdge(clock)
        for head, levels in heads.items():
            for name, values in levels.items():
                values[number] = int(getattr(dut, f"head{head}_{name}").value)
    # Compute the true angle that the pins show in clock k; in the first clock the entity has added
    # one step.
    true_counts = STEP * (np.arange(1, CLOCKS + 1) - LATENCY)
    index_clocks = {}
    for head, start in enumerate(AHEAD[:HEADS], start=1):
        levels = heads[head]
        counts = decoded(levels["a"], levels["b"])
        rising = np.flatnonzero(np.diff(levels["z"]) == 1) + 1
        assert rising.size >= 2, f"head {head}: {rising.size} indices in two turns"
        assert np.all(np.diff(counts[rising]) == COUNTS_PER_REV)
        reading = counts - counts[rising[0]]
        seen = np.arange(CLOCKS) >= rising[0]
        difference = reading - expected(true_counts + start)
        difference -= COUNTS_PER_REV * np.round(difference[rising[0]] / COUNTS_PER_REV)
        assert np.abs(difference[seen]).max() < BOUND_COUNTS
        index_clocks[head] = rising[0]
    for head, start in enumerate(AHEAD[1:HEADS], start=2):
        apart = (index_clocks[1] - index_clocks[head]) * STEP % COUNTS_PER_REV
        assert abs(apart - start) < 2 * sum(AMPLITUDES)
    for head in range(HEADS + 1, 5):
        assert not any(levels.any() for levels in heads[head].values())
