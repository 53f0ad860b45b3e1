"""Compares the VHDL sampler with its model in every clock, while a simulated processor accesses it.

The processor reads random words at random times and releases a bank after a random time. The bench
copies every write at the RAM's write port to a shadow memory, from which it takes the content of a
bank when this bank becomes READY.
"""

from __future__ import annotations

import functools
import operator
import os
import random
from dataclasses import dataclass, field

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge
from sim.tests.gateware.sampler_scenarios import SCENARIOS, Scenario, stimuli

from arctrue.gateware.sampler import FULL_BEFORE_TURN, SamplerInputs, SamplerTrace, sampler

READ_LATENCY = 4
HEADER = ("header_start_time", "header_sequence", "header_sample_count", "header_flags")
FLAG_PINS = (
    "index_seen1",
    "index_seen2",
    "index_error1",
    "index_error2",
    "illegal1",
    "illegal2",
    "overspeed1",
    "overspeed2",
)
TRACED = (
    "capture_ready",
    "capture_overrun",
    "capture_busy",
    "bank_ready",
    "ready_bank",
    "overrun_count",
    "fill_count",
    "trigger",
)
SHADOW: dict[int, list[int]] = {}
"""Shadow memories by depth; like the RAM, they keep their content from one test to the next.

With more than two heads, the higher bits of a word hold heads 3 and 4, the lower bits heads 1 and
2.
"""
HEADS = int(os.environ.get("HEADS", "2"))
FURTHER = 64
"""Number of bits of one pair of heads in a word of the shadow memory."""
WIDTH = {"turn_position1": 32, "turn_position2": 32}


@dataclass
class Seen:
    """Recorded outputs of the simulation, one entry per clock."""

    released: list[bool] = field(default_factory=list)
    outputs: list[tuple[int, ...]] = field(default_factory=list)
    headers: dict[int, tuple[int, ...]] = field(default_factory=dict)
    further_flags: dict[int, int] = field(default_factory=dict)
    banks: dict[int, list[int]] = field(default_factory=dict)
    """Words of each bank in the shadow memory, by the clock in which the bank became READY."""
    reads: int = 0


class Processor:
    """Simulates the processor: decides on reads and releases, and computes the expected data of
    each read."""

    def __init__(self, scenario: Scenario, seed: int) -> None:
        self.random = random.Random(seed)
        self.depth = scenario.depth
        self.hold = scenario.hold
        self.release_in: int | None = None
        self.expected: list[int | None] = [None] * READ_LATENCY

    def releases(self, ready: bool) -> bool:
        if not ready:
            self.release_in = None
            # A release while no bank is READY must have no effect.
            return self.random.random() < 0.02
        if self.release_in is None:
            self.release_in = self.random.randint(*self.hold)
        self.release_in -= 1
        return self.release_in < 0

    def reads(self, bank: list[int]) -> tuple[int, int] | None:
        """Return the address of a read in this clock, and 1 for head 3 or 4 or 0 for head 1 or 2.
        Return None if no read starts in this clock.

        ``bank`` contains the samples of the READY bank.
        """
        if self.random.random() < 0.4:
            self.expected.append(None)
            return None
        address = self.random.randrange(min(2 * self.depth + 6, 2**15))
        further = self.random.randrange(2) if HEADS > 2 else 0
        word = bank[address // 2] if address // 2 < len(bank) else 0
        self.expected.append(word >> FURTHER * further + 32 * (address % 2) & 0xFFFF_FFFF)
        return address, further


def drive_further_heads(dut, columns: dict[str, list[int]], clock: int) -> None:
    """Drive heads 3 and 4 with values of their own; head 1 is the reference head."""
    pair, flags = further_heads(columns, clock)
    dut.further_positions.value = pair
    dut.further_flags.value = flags
    dut.reference_position.value = columns["turn_position1"][clock]
    dut.reference_zero_moved.value = columns["zero_moved1"][clock]
    seen = columns["flags"][clock] & 3 == 3
    dut.enable.value = int(columns["enable"][clock] and seen)


def further_heads(columns: dict[str, list[int]], clock: int) -> tuple[int, int]:
    """Return the positions of heads 3 and 4 as one word, and their flags. The positions change in
    every clock; every 40 clocks another flag is inverted."""
    head3 = (5 * columns["turn_position1"][clock] + 11 * clock) % 2**32
    head4 = (columns["turn_position2"][clock] ^ 0x0F0F_3355) % 2**32
    return head3 | head4 << 32, columns["flags"][clock] ^ (1 << clock // 40 % 8)


def drive(dut, name: str, value: int) -> None:
    if name == "flags":
        for bit, pin in enumerate(FLAG_PINS):
            getattr(dut, pin).value = value >> bit & 1
    else:
        getattr(dut, name).value = value % 2 ** WIDTH.get(name, 64)


async def run(dut, scenario: Scenario, columns: dict[str, list[int]], seed: int) -> Seen:
    """Play the scenario, check the data of each read, and return the recorded outputs."""
    seen = Seen()
    processor = Processor(scenario, seed)
    shadow = SHADOW.setdefault(scenario.depth, [0] * (2 * scenario.depth))
    ready_words: list[int] = []
    last = dict.fromkeys(columns, None)

    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    for name in columns:
        drive(dut, name, columns[name][0])
    dut.release_bank.value = 0
    dut.read_enable.value = 0
    dut.read_address.value = 0
    dut.reset.value = 1
    for _ in range(8):
        await FallingEdge(dut.clock)

    handles = [getattr(dut, name) for name in TRACED]
    header = [getattr(dut, name) for name in HEADER]
    for clock in range(len(columns["reset"]) + 1):
        # Read the outputs of this clock before its inputs change.
        outputs = tuple(int(handle.value) for handle in handles)
        seen.outputs.append(outputs)
        ready, bank = outputs[3], outputs[4]
        if ready:
            seen.headers[clock] = tuple(int(handle.value) for handle in header)
            seen.further_flags[clock] = int(dut.header_further_flags.value)
            base = bank * scenario.depth
            if outputs[0]:
                ready_words = shadow[base : base + seen.headers[clock][2]]
                seen.banks[clock] = ready_words
        else:
            ready_words = []
        if dut.write_enable.value:
            address = int(dut.write_address.value)
            assert not (ready and address // scenario.depth == bank), (
                f"clock {clock}: word {address} written in the READY bank {bank}"
            )
            shadow[address] = int(dut.write_data.value)
            if HEADS > 2:
                shadow[address] |= int(dut.further_write_data.value) << FURTHER

        expected = processor.expected.pop(0)
        assert int(dut.read_valid.value) == (expected is not None), f"clock {clock}: read_valid"
        if expected is not None:
            seen.reads += 1
            got = int(dut.read_data.value)
            assert got == expected, f"clock {clock}: read {got:08x}, expected {expected:08x}"

        if clock == len(columns["reset"]):
            break
        for name, column in columns.items():
            if column[clock] != last[name]:
                last[name] = column[clock]
                drive(dut, name, column[clock])
        resetting = bool(columns["reset"][clock])
        release = processor.releases(bool(ready)) and not resetting
        seen.released.append(release)
        dut.release_bank.value = int(release)
        if HEADS > 2:
            drive_further_heads(dut, columns, clock)
        asked = None if resetting else processor.reads(ready_words)
        if resetting:
            # A reset drops reads in progress.
            processor.expected = [None] * READ_LATENCY
        dut.read_enable.value = int(asked is not None)
        dut.read_address.value, dut.read_further.value = asked or (0, 0)
        await FallingEdge(dut.clock)
    return seen


def compare(seen: Seen, model: SamplerTrace, columns: dict[str, list[int]]) -> None:
    got = np.array(seen.outputs)
    for column, name in enumerate(TRACED):
        wrong = np.flatnonzero(got[:, column] != getattr(model, name))
        assert not wrong.size, (
            f"{name}: first of {wrong.size} differences from the model in clock {wrong[0]}: "
            f"{got[wrong[0], column]}, model {getattr(model, name)[wrong[0]]}"
        )
    assert sorted(seen.banks) == [capture.clock for capture in model.captures]
    ready = np.flatnonzero(model.bank_ready)
    starts = np.array([capture.clock for capture in model.captures])
    for clock in ready:
        capture = model.captures[int(np.searchsorted(starts, clock, side="right")) - 1]
        header = (capture.start_time, capture.sequence, len(capture.samples), capture.flags)
        assert seen.headers[int(clock)] == header, f"clock {clock}: header"
    for capture in model.captures:
        words = [word % 2**FURTHER for word in seen.banks[capture.clock]]
        pairs = capture.samples.astype(np.int64) & 0xFFFF_FFFF
        assert words == (pairs[:, 0] | pairs[:, 1] << 32).astype(np.uint64).tolist()
        if HEADS > 2:
            first, last = int(capture.sample_clocks[0]), int(capture.sample_clocks[-1])
            others = [further_heads(columns, clock) for clock in range(first, last + 1)]
            of_samples = [others[clock - first][0] for clock in capture.sample_clocks.tolist()]
            assert [word >> FURTHER for word in seen.banks[capture.clock]] == of_samples
            flags = functools.reduce(operator.or_, (flags for _, flags in others))
            assert seen.further_flags[capture.clock] == flags
        else:
            assert seen.further_flags[capture.clock] == 0


def check_expectations(scenario: Scenario, model: SamplerTrace) -> None:
    happened = {
        "captures": len(model.captures),
        "overruns": int(model.capture_overrun.sum()),
        "full": sum(bool(capture.flags & FULL_BEFORE_TURN) for capture in model.captures),
    }
    for what, least in scenario.expect.items():
        enough = happened[what] >= least if least else happened[what] == 0
        assert enough, f"{what}: {happened[what]}, the scenario should give {least}"


@cocotb.test()
@cocotb.parametrize(
    name=[
        name
        for name, scenario in SCENARIOS.items()
        if scenario.depth == int(os.environ.get("CAPTURE_DEPTH", "16"))
    ]
)
async def follows_the_model(dut, name: str) -> None:
    scenario = SCENARIOS[name]
    columns = {key: column.tolist() for key, column in stimuli(scenario).items()}
    seen = await run(dut, scenario, columns, seed=len(name))
    model = sampler(SamplerInputs(**columns, release_bank=seen.released), scenario.depth)
    check_expectations(scenario, model)
    compare(seen, model, columns)
    assert seen.reads > len(seen.released) // 2
    dut._log.info(
        "%d clocks, %d captures, %d reads", len(seen.released), len(model.captures), seen.reads
    )
