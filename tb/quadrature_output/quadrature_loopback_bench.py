"""Connects the quadrature output to the decoder, which must recover every count and index."""

from __future__ import annotations

from dataclasses import dataclass

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge
from numpy.typing import NDArray

from arctrue.gateware.quadrature_output import LATENCY as OUTPUT_LATENCY

DECODER_LATENCY = 4
"""Latency of the decoder in clocks, without its filter: synchroniser 2, decoding 2."""

REST = 60
RESETS = 8


@dataclass(frozen=True)
class LoopBack:
    counts_per_rev: int
    minimum_spacing: int
    clocks_a_count: int
    """Smallest number of clocks between two counts of the position."""
    filter_length: int = 1
    clocks: int = 8000
    start: int = 0


CASES = {
    "edge_every_clock": LoopBack(256, 1, 1),
    "edge_every_clock_odd_turn": LoopBack(97, 1, 1, start=-12_345),
    "smallest_turn": LoopBack(4, 1, 1, clocks=3000, start=2),
    "spacing_3": LoopBack(61, 3, 3),
    "filter_3_spacing_4": LoopBack(61, 4, 4, filter_length=3, start=1_000_000),
    "spacing_10_of_the_reset_value": LoopBack(37, 10, 10, filter_length=5, start=5),
    "position_wrap": LoopBack(120, 2, 2, start=2**31 - 50),
}


def motion(case: LoopBack, seed: int) -> NDArray[np.int64]:
    """Return the position in each clock of a random motion with long travels, reversals at every
    count, standstills, and a final standstill."""
    random = np.random.default_rng(seed)
    counts = np.zeros(case.clocks, dtype=np.int64)
    edge = 2 * RESETS
    way, left = 1, 0
    while edge < case.clocks - REST:
        if left == 0:
            way = int(random.choice([-1, 1]))
            left = int(
                random.choice([1, 2, 3, 7, case.counts_per_rev, 2 * case.counts_per_rev + 3])
            )
        counts[edge] = way
        left -= 1
        edge += case.clocks_a_count + (int(random.integers(0, 9)) if random.random() < 0.05 else 0)
    # The last counts go in one direction, which removes the hysteresis before the final comparison.
    counts[edge - case.clocks_a_count : case.clocks - REST // 2 : case.clocks_a_count] = way
    return case.start + np.cumsum(counts)


@cocotb.test()
@cocotb.parametrize(name=list(CASES))
async def loses_no_count(dut, name: str) -> None:
    case = CASES[name]
    position = motion(case, seed=len(name))
    angle = position % case.counts_per_rev
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.enable.value = 1
    dut.counts_per_rev.value = case.counts_per_rev
    dut.minimum_spacing.value = case.minimum_spacing
    dut.filter_length.value = case.filter_length

    # A reset keeps the levels of A and B. `phase_of_zero` is chosen so that these are the levels of
    # the first position: then no edge comes after the reset.
    dut.reset.value = 1
    for _ in range(4):
        await FallingEdge(dut.clock)
    held_place = (0, 3, 1, 2)[2 * int(dut.a.value) + int(dut.b.value)]
    dut.phase_of_zero.value = (held_place - int(position[0])) % 4
    received, received_angle, index = [], [], []
    sent = list(zip((position % 2**32).tolist(), angle.tolist(), strict=True))
    for clock, (counts, of_turn) in enumerate(sent):
        dut.reset.value = int(clock < RESETS)
        dut.corrected_position.value = counts
        dut.corrected_angle.value = of_turn
        await FallingEdge(dut.clock)
        if clock >= RESETS:
            for fault in ("illegal", "index_error", "overspeed", "cannot_keep_up"):
                assert not getattr(dut, fault).value, f"clock {clock}: {fault}"
            received.append(dut.position.value.to_signed())
            received_angle.append(int(dut.angle.value))
            index.append(int(dut.index_seen.value))

    latency = OUTPUT_LATENCY + DECODER_LATENCY + case.filter_length
    got = np.array(received)
    # Element i was read after the rising edge that sampled sample RESETS + i. This edge is the
    # first of the `latency` edges for that sample.
    then = np.arange(RESETS, len(sent)) + 1 - latency
    expected = position[np.maximum(then, 0)]
    slack = np.abs(got - (expected - position[0]))
    # The output has a hysteresis of one count, and may need two clocks per count to catch up after
    # a reversal.
    assert slack.max() <= 1, f"clock {RESETS + int(slack.argmax())}: off by {slack.max()} counts"
    assert got[-1] == position[-1] - position[0]

    seen = np.flatnonzero(index)
    assert seen.size > case.clocks // 4, "the index was not seen early enough"
    off = (np.array(received_angle) - expected) % case.counts_per_rev
    off = np.minimum(off, case.counts_per_rev - off)[seen]
    assert off.max() <= 1
    assert received_angle[-1] == angle[-1]
