"""Tests in cocotb that prepared_sets loads complete sets even if the processor writes meanwhile."""

from __future__ import annotations

import os
import random
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

HEADS = int(os.environ.get("HEADS", "4"))
LANES = int(os.environ.get("LANES", "4"))
MEAN_PLACES = (*range(9), 15)
LANE_PLACES = range(4 * LANES)
INPUTS = (
    *("access_read", "access_write", "access_set", "access_word", "access_data"),
    *("write_lane", "write_offset", "write_mean", "write_address", "write_data"),
    *("swap", "load", "number", "acknowledged", "swap_comes", "may_activate"),
)
Place = tuple[str, int]


async def start(dut: Any) -> None:
    for name in INPUTS:
        getattr(dut, name).value = int(name == "may_activate")
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(3):
        await RisingEdge(dut.clock)
    dut.reset.value = 0
    await RisingEdge(dut.clock)


def place_of(word: int) -> Place:
    """Return the place in the bank to which a word of a set is written."""
    if word < 512:
        return "lane", word
    return ("offset", 0) if word - 512 == 15 else ("mean", word - 512)


WORDS = [*LANE_PLACES, *(512 + place for place in MEAN_PLACES)]


async def access(dut: Any, number: int, word: int, data: int | None = None) -> int:
    dut.access_set.value = number
    dut.access_word.value = word
    dut.access_data.value = data or 0
    dut.access_read.value = int(data is None)
    dut.access_write.value = int(data is not None)
    await RisingEdge(dut.clock)
    dut.access_read.value = 0
    dut.access_write.value = 0
    for _ in range(2000):
        await RisingEdge(dut.clock)
        if dut.access_done.value == 1:
            return dut.access_answer.value.to_unsigned()
    raise AssertionError("no answer")


class Bank:
    """Simulates the idle bank, to which the entity writes, and the active bank."""

    def __init__(self, dut: Any, choose: random.Random) -> None:
        self.dut = dut
        self.choose = choose
        self.idle: dict[Place, int] = {}
        self.active: dict[Place, int] = {}
        self.pending: tuple[Place, int, int] | None = None
        self.waits = 0
        self.filling = 0
        self.swaps: list[tuple[bool, dict[Place, int]]] = []
        self.clock = 0

    async def run(self) -> None:
        """Acknowledge each write after two clocks or more, and make each swap come after a random
        time; acknowledge no write while a swap waits."""
        dut = self.dut
        while True:
            asked = dut.swap_out.value == 1
            comes = 0
            if asked or self.waits:
                self.waits = 1
                comes = int(self.filling == 0 and self.choose.random() < 0.3)
            dut.swap_comes.value = comes
            acknowledge = 0
            if self.pending and not self.waits and not asked and not self.filling:
                place, data, left = self.pending
                self.pending = (place, data, left - 1)
                if left == 1:
                    self.idle[place] = data
                    acknowledge = 1
                    self.pending = None
            dut.acknowledged.value = acknowledge
            await RisingEdge(dut.clock)
            self.clock += 1
            if comes:
                self.swaps.append((dut.loaded.value == 1, dict(self.idle)))
                self.active = dict(self.idle)
                self.waits, self.filling = 0, 20
            else:
                self.filling = max(self.filling - 1, 0)
            kinds = [
                name
                for name in ("lane", "offset", "mean")
                if getattr(dut, f"{name}_out").value == 1
            ]
            assert len(kinds) <= 1
            if kinds:
                assert self.pending is None, "a write before the last one was acknowledged"
                address = dut.address_out.value.to_unsigned()
                place = (kinds[0], 0 if kinds[0] == "offset" else address)
                self.pending = (place, dut.data_out.value.to_unsigned(), 2)


async def fill(dut: Any, choose: random.Random) -> dict[int, dict[Place, int]]:
    """Write random words into all prepared sets and read them back; return the words."""
    sets: dict[int, dict[Place, int]] = {}
    for number in range(HEADS + 1):
        words = {word: choose.getrandbits(32) for word in WORDS}
        for word, data in words.items():
            await access(dut, number, word, data)
        sets[number] = {place_of(word): data for word, data in words.items()}
    for number, words_of_set in sets.items():
        for word in WORDS:
            assert await access(dut, number, word) == words_of_set[place_of(word)]
    return sets


@cocotb.test()
async def every_set_is_loaded_whole(dut: Any) -> None:
    """Each load activates the complete set, within the number of clocks that the header of the
    entity states."""
    choose = random.Random(HEADS)
    await start(dut)
    sets = await fill(dut, choose)
    bank = Bank(dut, choose)
    cocotb.start_soon(bank.run())
    for number in [*range(HEADS + 1), *(choose.randrange(HEADS + 1) for _ in range(8))]:
        for _ in range(30):
            await RisingEdge(dut.clock)
        dut.load.value, dut.number.value = 1, number
        await RisingEdge(dut.clock)
        dut.load.value = 0
        clocks = 0
        while dut.swap_out.value == 0:
            await RisingEdge(dut.clock)
            clocks += 1
        assert clocks <= 4 * (4 * LANES + 10) + 4
        while dut.busy.value == 1:
            await RisingEdge(dut.clock)
        assert bank.swaps[-1] == (True, sets[number])


@cocotb.test()
async def writes_of_the_processor_wait_and_nothing_mixed_is_swapped(dut: Any) -> None:
    """Each write of the processor gets the acknowledgement of its kind, and each swapped set is
    whole, while writes, swaps and loads are random.

    The entity swaps no words while `may_activate` is low; `refused` pulses instead.
    """
    choose = random.Random(20 + HEADS)
    await start(dut)
    sets = await fill(dut, choose)
    bank = Bank(dut, choose)
    cocotb.start_soon(bank.run())
    loads = absorbed = acknowledged = refused = pause = 0
    under_way: tuple[Place, int] | None = None
    for _ in range(20_000):
        busy = dut.busy.value == 1
        # A value that is read at an edge is the value before the edge, so `busy` shows a load two
        # clocks later.
        pause = max(pause - 1, 0)
        load = not busy and not pause and choose.random() < 0.01
        swap = under_way is None and choose.random() < 0.02
        dut.load.value = int(load)
        if load:
            number = choose.randrange(HEADS + 1)
            dut.number.value = number
            loads += 1
            pause = 3
        dut.swap.value = int(swap)
        may_activate = choose.random() < 0.8
        dut.may_activate.value = int(may_activate)
        absorbed += swap and busy
        begins = under_way is None and not swap and choose.random() < 0.03
        kind = choose.choice(["lane", "offset", "mean"])
        if begins:
            address = choose.choice({"lane": LANE_PLACES, "mean": range(9), "offset": [0]}[kind])
            under_way = (kind, address), choose.getrandbits(32)
            dut.write_address.value, dut.write_data.value = address, under_way[1]
        for name in ("lane", "offset", "mean"):
            getattr(dut, f"write_{name}").value = int(begins and kind == name)
        before = len(bank.swaps)
        await RisingEdge(dut.clock)
        refused += dut.refused.value == 1
        assert not (dut.refused.value == 1 and dut.swap_out.value == 1)
        assert may_activate or dut.swap_out.value == 0, "refused words are swapped"
        assert not may_activate or dut.refused.value == 0
        if dut.swap_out.value == 1 and dut.busy.value == 1:
            assert bank.idle in sets.values(), "a set that is not whole is swapped"
        if under_way and (dut.acknowledge_lane.value == 1 or dut.acknowledge_mean.value == 1):
            assert (dut.acknowledge_mean.value == 1) == (under_way[0][0] == "mean")
            under_way = None
            acknowledged += 1
        for is_set, words in bank.swaps[before:]:
            assert not is_set or words in sets.values()
    assert loads - 1 <= sum(is_set for is_set, _ in bank.swaps) + refused
    assert min(loads, absorbed, acknowledged, refused) > 20
