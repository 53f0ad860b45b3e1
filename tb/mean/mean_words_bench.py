"""Tests in cocotb that mean_words activates all written words (weights, offsets and carrier of the
mean) together and reads them back."""

from __future__ import annotations

import os
import random
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.generated.number_formats import HEAD_OFFSET_WIDTH, HEAD_WEIGHT_WIDTH, HEADS_MAX

HEADS = int(os.environ.get("HEADS", "2"))
CHOICE = 2 * HEADS_MAX
HEAD1_ALONE = {**dict.fromkeys(range(CHOICE), 0), CHOICE: 1 << 4}


def stored(address: int, data: int) -> int:
    """Return the 32 bits that a read of ``address`` returns after ``data`` was written there."""
    if address < CHOICE:
        if address % HEADS_MAX >= HEADS:
            return 0
        if address < HEADS_MAX:
            return data % (1 << HEAD_OFFSET_WIDTH)
        half = 1 << (HEAD_WEIGHT_WIDTH - 1)
        return ((data % (2 * half) ^ half) - half) % 2**32
    if address > CHOICE:
        return 0
    carrier = data & 3 if data & 3 < HEADS else 0
    return carrier | (data >> 4 & (1 << HEADS) - 1) << 4


def activated(words: dict[int, int]) -> dict[int, int]:
    """Return the active words after a swap: those that were in the idle bank, with weight 0 for
    heads that are not in use."""
    used = words[CHOICE] >> 4
    unused = [HEADS_MAX + head for head in range(HEADS) if not used >> head & 1]
    return {**words, **dict.fromkeys(unused, 0)}


def flat_words(words: dict[int, int]) -> int:
    """Return the words as one integer, in the layout of the entity's ports."""
    value = place = 0
    parts = [(words[head], HEAD_OFFSET_WIDTH) for head in range(HEADS)]
    parts += [
        (words[HEADS_MAX + head] % (1 << HEAD_WEIGHT_WIDTH), HEAD_WEIGHT_WIDTH)
        for head in range(HEADS)
    ]
    parts += [(words[CHOICE] >> 4, HEADS), (words[CHOICE] & 3, 2)]
    for part, width in parts:
        value |= part << place
        place += width
    return value


@cocotb.test()
async def swaps_are_whole(dut: Any) -> None:
    """Each swap activates all words of the idle bank together, while writes, reads and swaps are
    random; a write waits while `hold_writes` is high."""
    choose = random.Random(HEADS)
    for name in ("reset", "write_enable", "write_address", "write_data", "hold_writes"):
        getattr(dut, name).value = 0
    dut.swap_comes.value = 0
    dut.read_address.value = 0
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    await RisingEdge(dut.clock)
    active, idle = dict(HEAD1_ALONE), dict(HEAD1_ALONE)
    pending: tuple[int, int] | None = None
    expected_read: int | None = None
    waited = swaps = 0
    for _ in range(6000):
        start = pending is None and choose.random() < 0.3
        hold = choose.random() < 0.3
        swap = hold and choose.random() < 0.2
        if start:
            pending = choose.randrange(16), choose.getrandbits(32)
            dut.write_address.value, dut.write_data.value = pending
        dut.write_enable.value = int(start)
        dut.hold_writes.value = int(hold)
        dut.swap_comes.value = int(swap)
        address = choose.randrange(16)
        dut.read_address.value = address
        await RisingEdge(dut.clock)
        # The values read here are those before this edge: they belong to the clock that ends with
        # it.
        assert dut.active_words.value.to_unsigned() == flat_words(active)
        assert dut.idle_words.value.to_unsigned() == flat_words(idle)
        assert dut.next_words.value.to_unsigned() == flat_words(idle if swap else active)
        if expected_read is not None:
            assert dut.read_data.value.to_unsigned() == expected_read
        expected_read = idle.get(address, 0)
        if swap:
            active = activated(idle)
            swaps += 1
        if dut.is_written.value == 1:
            assert pending is not None
            assert not hold
            if pending[0] <= CHOICE:
                idle[pending[0]] = stored(*pending)
        waited += hold and pending is not None
        if dut.write_acknowledge.value == 1:
            pending = None
    assert swaps > 100
    assert waited > 100


@cocotb.test()
async def a_reset_keeps_the_words(dut: Any) -> None:
    """A reset keeps the stored words and drops a write that waits."""
    for name in ("reset", "swap_comes", "hold_writes", "read_address"):
        getattr(dut, name).value = 0
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    await RisingEdge(dut.clock)
    before = dut.idle_words.value
    dut.hold_writes.value = 1
    dut.write_address.value = 0
    dut.write_data.value = before.to_unsigned() % 2**28 ^ 5
    dut.write_enable.value = 1
    await RisingEdge(dut.clock)
    dut.write_enable.value = 0
    dut.reset.value = 1
    await RisingEdge(dut.clock)
    dut.reset.value = 0
    dut.hold_writes.value = 0
    for _ in range(5):
        await RisingEdge(dut.clock)
        assert dut.write_acknowledge.value == 0
    assert dut.idle_words.value == before
