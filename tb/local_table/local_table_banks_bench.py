"""Tests the writes, swaps and copies of local_table_banks in cocotb, clock by clock."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge
from numpy.typing import NDArray

from arctrue.gateware.extension import POINTS
from arctrue.gateware.local_table import LocalTable, local_table
from arctrue.generated.number_formats import LOCAL_TABLE_LATENCY
from tb.local_table.local_table_bench import random_table

COUNTS_PER_REV = int(os.environ["COUNTS_PER_REV"])
COPY_CLOCKS = LOCAL_TABLE_LATENCY + 2 * POINTS + 1
"""Largest number of clocks for which an access waits for the copy, as the header of the entity
states; the access itself takes two or three clocks more."""
STEADY = 3
"""Number of clocks after which the windows follow a new counts_per_rev."""


class Unit:
    """Drives the entity with a new angle in every clock; logs each angle, the table that applies to
    it, and each output value."""

    def __init__(self, dut: Any, seed: int) -> None:
        self.dut = dut
        self.random = np.random.default_rng(seed)
        self.active: LocalTable | None = None
        self.next: LocalTable | None = None
        self.angles: list[int] = []
        self.tables: list[LocalTable | None] = []
        self.values: list[int] = []

    async def start(self) -> None:
        for name in ("swap_comes", "hold", "read_enable", "write_enable", "of_place", "address"):
            getattr(self.dut, name).value = 0
        self.dut.angle.value = 0
        self.dut.counts_per_rev.value = COUNTS_PER_REV
        self.dut.reset.value = 1
        Clock(self.dut.clock, 10, unit="ns", impl="gpi").start()
        for _ in range(STEADY):
            await FallingEdge(self.dut.clock)
        self.dut.reset.value = 0
        # Disable all windows, because an earlier test of this simulation may have left a table.
        await self.access(place=True, address=0, word=0)
        await self.swap(takes=True)
        await self.access(place=True, address=0, word=None)
        self.angles, self.tables, self.values = [], [], []

    async def clock(self) -> None:
        """Drive an angle for one clock, and log the output value of this clock."""
        near = self.random.integers(0, 3)
        tables = [self.active, self.next]
        table = tables[near] if near < 2 else None
        if table is None:
            angle = int(self.random.integers(COUNTS_PER_REV))
        else:
            start = int(self.random.choice(table.starts))
            ends = start, start + -(-COUNTS_PER_REV // 2**table.width)
            angle = (
                ends[self.random.integers(2)] + int(self.random.integers(-5, 6))
            ) % COUNTS_PER_REV
        self.dut.angle.value = angle
        self.angles.append(angle)
        self.tables.append(self.active)
        await FallingEdge(self.dut.clock)
        self.values.append(self.dut.value.value.to_signed())

    async def clocks(self, number: int) -> None:
        for _ in range(number):
            await self.clock()

    async def access(self, *, place: bool, address: int, word: int | None) -> tuple[int, int]:
        """Write ``word``, or read if it is None; return the word that was read, and the number of
        clocks that the access waited."""
        dut = self.dut
        dut.of_place.value, dut.address.value = int(place), address
        dut.write_data.value = (word or 0) & 0xFFFF_FFFF
        name = "read_enable" if word is None else "write_enable"
        getattr(dut, name).value = 1
        await self.clock()
        getattr(dut, name).value = 0
        waited = 1
        while dut.done.value != 1:
            assert waited <= COPY_CLOCKS + 4, "no answer"
            await self.clock()
            waited += 1
        return int(dut.read_data.value), waited

    async def write(self, table: LocalTable) -> None:
        for number, point in enumerate(table.points.tolist()):
            await self.access(place=False, address=number, word=point)
        for number, word in reversed(list(enumerate(table.place_words()))):
            await self.access(place=True, address=number, word=word)
        self.next = table

    async def swap(self, *, takes: bool) -> None:
        self.dut.hold.value = 1
        self.dut.swap_comes.value = 1
        await self.clock()
        self.dut.hold.value = 0
        self.dut.swap_comes.value = 0
        if takes:
            self.active, self.next = self.next, None

    async def idle_words(self, numbers: NDArray[np.int64]) -> tuple[list[int], list[int]]:
        points = [
            (await self.access(place=False, address=number, word=None))[0]
            for number in numbers.tolist()
        ]
        place = [(await self.access(place=True, address=n, word=None))[0] for n in range(7)]
        return points, place

    def judge(self) -> None:
        """Check that every output value equals the model's value LOCAL_TABLE_LATENCY clocks after
        its angle."""
        expected = np.zeros(len(self.angles), dtype=np.int64)
        angles = np.array(self.angles)
        for table in {id(one): one for one in self.tables if one is not None}.values():
            met = np.array([one is table for one in self.tables])
            expected[met] = local_table(angles[met], table)
        found = np.array(self.values)[LOCAL_TABLE_LATENCY - 1 :]
        apart = np.flatnonzero(found != expected[: found.size])
        assert not apart.size, (apart[:5], angles[apart[:5]], found[apart[:5]], expected[apart[:5]])


def shapes() -> Iterator[tuple[int, int]]:
    yield from ((1, 0), (4, 3), (2, 1))


@cocotb.test()
async def a_table_acts_with_its_swap_and_is_kept(dut: Any) -> None:
    """Each of three tables acts from its swap on, and later swaps of the lanes do not change it."""
    unit = Unit(dut, 1)
    await unit.start()
    await unit.swap(takes=False)
    places = np.array([0, 1, 2, 1023, 1024, 2047, 2048, 4094, 4095])
    for windows, width in shapes():
        table = random_table(unit.random, windows, width)
        await unit.write(table)
        await unit.clocks(50)
        await unit.swap(takes=True)
        _, waited = await unit.access(place=False, address=0, word=None)
        assert COPY_CLOCKS - 4 <= waited <= COPY_CLOCKS + 3, (
            "the access did not wait for the end of the copy"
        )
        await unit.swap(takes=False)
        await unit.clocks(50)
        points, place = await unit.idle_words(places)
        assert points == [int(table.points[n]) & 0xFFFF_FFFF for n in places]
        assert place == table.place_words(), "the copied words of the place differ"
    # Write only one point and `choice`; all other points of the table must come from the copy.
    changed = LocalTable(
        table.counts_per_rev, table.starts, table.width, table.fraction, table.points.copy()
    )
    changed.points[77] = -5
    await unit.access(place=False, address=77, word=-5)
    await unit.access(place=True, address=0, word=table.place_words()[0])
    unit.next = changed
    await unit.swap(takes=True)
    await unit.clocks(3000)
    unit.judge()


@cocotb.test()
async def a_write_waits_for_a_swap(dut: Any) -> None:
    """While `hold` is high, no word is written; a reset drops a requested swap of the table."""
    unit = Unit(dut, 2)
    await unit.start()
    table = random_table(unit.random, 1, 2)
    await unit.write(table)
    dut.hold.value = 1
    dut.of_place.value, dut.address.value, dut.write_data.value = 1, 1, 5
    dut.write_enable.value = 1
    await unit.clock()
    dut.write_enable.value = 0
    for _ in range(20):
        await unit.clock()
        assert dut.done.value == 0
    dut.swap_comes.value = 1
    await unit.clock()
    dut.swap_comes.value, dut.hold.value = 0, 0
    unit.active, unit.next = table, None
    waited = 0
    while dut.done.value != 1:
        await unit.clock()
        waited += 1
        assert waited <= COPY_CLOCKS + 3, "no answer"
    assert waited >= COPY_CLOCKS - 4, "the access did not wait for the end of the copy"
    assert (await unit.access(place=True, address=1, word=None))[0] == 5
    await unit.access(place=True, address=0, word=0)
    dut.reset.value = 1
    await unit.clock()
    dut.reset.value = 0
    await unit.swap(takes=False)
    await unit.clocks(200)
    unit.judge()
