"""Compares turn_offset_sweep with its model in cocotb tests."""

from __future__ import annotations

import os
import random
from fractions import Fraction
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.turn_offset_sweep import PLACES, ready_clocks, turn_offsets
from arctrue.generated.number_formats import TURN_SWEEP_CLOCKS_A_LANE

LANES = int(os.environ.get("LANES", "8"))
FOLD = int(os.environ.get("FOLD", "1"))
BUILT = LANES // FOLD
SWEEP_CLOCKS = TURN_SWEEP_CLOCKS_A_LANE * LANES
COPY_CLOCKS = SWEEP_CLOCKS + 4
PULSES = ("write_low", "write_high", "write_offset", "take_over")


class Memory:
    """Simulates the pipeline's memory of the prepared offsets, by bank, place and lane."""

    def __init__(self, dut: Any) -> None:
        self.dut = dut
        self.offsets = np.zeros((2, PLACES, LANES), dtype=np.int64)

    async def clock(self) -> None:
        await RisingEdge(self.dut.clock)
        columns = str(self.dut.selected.value)
        assert columns.count("1") <= 1
        if "1" in columns:
            lane = int(self.dut.slot.value) * BUILT + columns.index("1")
            bank, turn = int(self.dut.bank.value), int(self.dut.of_turn.value)
            self.offsets[bank, turn, lane] = int(self.dut.prepared.value)

    async def clocks(self, number: int) -> None:
        for _ in range(number):
            await self.clock()

    def of(self, bank: int, turn: int) -> list[int]:
        return self.offsets[bank, turn % PLACES].tolist()


async def start(dut: Any) -> Memory:
    for name in (*PULSES, "turn", "idle_bank", "write_lane", "write_word", "read_address"):
        getattr(dut, name).value = 0
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    memory = Memory(dut)
    await memory.clocks(COPY_CLOCKS + 4)
    return memory


async def write(memory: Memory, kind: str, lane: int, word: int) -> None:
    dut = memory.dut
    getattr(dut, kind).value = 1
    dut.write_lane.value = lane
    dut.write_word.value = word
    await memory.clock()
    getattr(dut, kind).value = 0


async def load(memory: Memory, steps: list[int], offsets: list[int]) -> None:
    for lane, (step, offset) in enumerate(zip(steps, offsets, strict=True)):
        await write(memory, "write_low", lane, step & 0xFFFF_FFFF)
        await write(memory, "write_high", lane, step >> 32)
        await write(memory, "write_offset", lane, offset)


def random_words(seed: int) -> tuple[list[int], list[int]]:
    rng = random.Random(seed)
    steps = [rng.getrandbits(48) for _ in range(LANES)]
    # The first four steps belong to an integer order, a half order, and orders with the largest and
    # the smallest fraction.
    steps[:4] = [0, 1 << 47, (1 << 48) - 1, 1]
    return steps, [rng.getrandbits(24) for _ in range(LANES)]


def check(memory: Memory, bank: int, turn: int, steps: list[int], offsets: list[int]) -> None:
    for near in (turn - 1, turn, turn + 1):
        assert memory.of(bank, near) == turn_offsets(near, steps, offsets).tolist(), near


@cocotb.test()
async def every_turn_is_exact(dut: Any) -> None:
    """For any turn number in s23.0 the offsets are ready in time and correct to 2⁻²⁵ turn."""
    memory = await start(dut)
    steps, offsets = random_words(1)
    await load(memory, steps, offsets)
    rng = random.Random(2)
    turns = [0, 1, -1, 1_000_000, -1_000_000, 2**23 - 2, -(2**23) + 1]
    for turn in turns + [rng.randrange(-(2**23) + 1, 2**23 - 1) for _ in range(10)]:
        dut.turn.value = turn
        # The time in the header includes 2 clocks until `turn` and 2 clocks of a read, which this
        # bench does not need.
        await memory.clocks(ready_clocks(LANES) - 4)
        check(memory, 0, turn, steps, offsets)
        for lane in range(LANES):
            exact = Fraction(turn * steps[lane], 1 << 48) + Fraction(offsets[lane], 1 << 24)
            away = (Fraction(memory.of(0, turn)[lane], 1 << 24) - exact) % 1
            assert min(away, 1 - away) <= Fraction(1, 1 << 25)


@cocotb.test()
async def tremble_keeps_the_neighbours(dut: Any) -> None:
    """While the table vibrates over a wrap, the offsets of the turns on both sides never change."""
    memory = await start(dut)
    steps, offsets = random_words(3)
    await load(memory, steps, offsets)
    rng = random.Random(4)
    turn = 71
    dut.turn.value = turn
    await memory.clocks(ready_clocks(LANES))
    wanted = [turn_offsets(turn + side, steps, offsets).tolist() for side in (-1, 0, 1)]
    for side in (1, -1):
        for _ in range(300):
            dut.turn.value = turn + rng.choice([0, side])
            await memory.clocks(rng.choice([1, 2, 3, 7, 50]))
            for place, of_turn in enumerate(wanted):
                # The vibration does not use the offsets of the turn on the other side.
                if place - 1 != -side:
                    assert memory.of(0, turn + place - 1) == of_turn
        dut.turn.value = turn
        await memory.clocks(ready_clocks(LANES))
        check(memory, 0, turn, steps, offsets)


@cocotb.test()
async def a_write_during_a_tremble_is_complete(dut: Any) -> None:
    """After a write, while the table vibrates over a wrap, the offsets of the turns on both sides
    are new when `swept` rises."""
    memory = await start(dut)
    rng = random.Random(8)
    for seed in range(6):
        steps, offsets = random_words(10 + seed)
        await load(memory, steps, offsets)
        turn = rng.randrange(-1000, 1000)
        dut.turn.value = turn
        while dut.swept.value != 1:
            dut.turn.value = turn + rng.randrange(2)
            await memory.clocks(rng.choice([1, 2, 5, 3 * LANES, 6 * LANES]))
        for near in (turn, turn + 1):
            assert memory.of(0, near) == turn_offsets(near, steps, offsets).tolist()


@cocotb.test()
async def turns_one_after_the_other(dut: Any) -> None:
    """After each wrap, in either direction, the offsets of the following turn are ready in the time
    that the header states."""
    memory = await start(dut)
    steps, offsets = random_words(5)
    await load(memory, steps, offsets)
    turn = 0
    await memory.clocks(ready_clocks(LANES))
    for way in (1, -1):
        for _ in range(9):
            turn += way
            dut.turn.value = turn
            await memory.clocks(ready_clocks(LANES) - 4)
            assert memory.of(0, turn + way) == turn_offsets(turn + way, steps, offsets).tolist()


@cocotb.test()
async def banks_and_take_over(dut: Any) -> None:
    """Writes change only the idle bank, `take_over` copies the steps to the other bank, and `swept`
    rises once the offsets of the writes or of the copy are computed."""
    memory = await start(dut)
    steps, offsets = random_words(6)
    await load(memory, steps, offsets)
    dut.turn.value = 5
    waited = 0
    while dut.swept.value != 1:
        await memory.clock()
        waited += 1
    assert 2 * SWEEP_CLOCKS <= waited <= ready_clocks(LANES)
    check(memory, 0, 5, steps, offsets)
    # After the swap bank 0 is active. The copy writes the steps of bank 0 into bank 1, and the
    # sweep writes the offsets of bank 1.
    dut.idle_bank.value = 1
    dut.take_over.value = 1
    await memory.clock()
    dut.take_over.value = 0
    await memory.clock()
    for lane, offset in enumerate(offsets):
        await write(memory, "write_offset", lane, offset)
    copied = LANES + 1
    while dut.copies.value == 1:
        # Even during the copy, a read returns the step of the bank that the swap has activated.
        dut.read_address.value = 2 * (copied % LANES) + copied % 2
        step = steps[copied % LANES]
        await memory.clocks(2)
        word = step >> 32 if copied % 2 else step & 0xFFFF_FFFF
        assert int(dut.read_word.value) == word
        copied += 2
        assert dut.swept.value == 0
    assert copied <= COPY_CLOCKS + 4
    while dut.swept.value != 1:
        await memory.clock()
    for bank in (0, 1):
        check(memory, bank, 5, steps, offsets)
    # Another write changes only bank 1.
    await write(memory, "write_low", LANES - 1, 12345)
    changed = [*steps[:-1], steps[-1] >> 32 << 32 | 12345]
    await memory.clocks(ready_clocks(LANES))
    check(memory, 0, 5, steps, offsets)
    check(memory, 1, 5, changed, offsets)
