"""Tests the registers and modulators of table_conditions in cocotb; a simulated table moves."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import cocotb
import pytest
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.table_conditions import MODULATOR_ONE, slewed, unit_quotient
from arctrue.generated.number_formats import AMPLITUDE_SWEEP_CLOCKS

WIDTH, DEAD_ZONE, NOMINAL, WORD_A, WORD_B, SLEW, DIRECTION, SPEED, SQUARED = range(9)
WINDOW = 1 << 8
LONGEST = 1 << 13
KNOWN = 1 << 31


class Window:
    """Drives the reading of a moving table clock by clock, and accesses the registers of the
    entity."""

    def __init__(self, dut: Any) -> None:
        self.dut = dut
        self.place = 0.0
        self.speed = 0.0

    async def start(self) -> None:
        for name in ("position", "put_back", "corrected_position", "correction"):
            getattr(self.dut, name).value = 0
        for name in ("read_enable", "write_enable", "address", "write_data", "speed_squared"):
            getattr(self.dut, name).value = 0
        self.dut.hold_writes.value = self.dut.swap_comes.value = 0
        self.dut.reset.value = 1
        cocotb.start_soon(Clock(self.dut.clock, 10, unit="ns", impl="gpi").start())
        for _ in range(8):
            await RisingEdge(self.dut.clock)
        self.dut.reset.value = 0

    async def clock(self, number: int = 1) -> None:
        for _ in range(number):
            self.place += self.speed
            self.dut.position.value = int(self.place // 1)
            self.dut.corrected_position.value = int(self.place // 1)
            await RisingEdge(self.dut.clock)

    async def write_idle(self, address: int, word: int) -> None:
        """Write a word; a word of a bank becomes active with the next swap."""
        self.dut.address.value = address
        self.dut.write_data.value = word & 0xFFFF_FFFF
        self.dut.write_enable.value = 1
        await self.clock()
        self.dut.write_enable.value = 0
        await self.clock(1 if address > NOMINAL else 2)
        assert self.dut.done.value

    async def write(self, address: int, word: int) -> None:
        """Write a word, and make it active if it belongs to a bank."""
        await self.write_idle(address, word)
        if address <= NOMINAL:
            await self.swap()

    async def swap(self) -> None:
        """Swap as coefficient_memory does, when the conditions are settled."""
        self.dut.hold_writes.value = 1
        while True:
            await self.clock()
            if self.dut.settled.value == 1:
                break
        self.dut.swap_comes.value = 1
        await self.clock()
        self.dut.swap_comes.value = self.dut.hold_writes.value = 0

    async def read(self, address: int) -> int:
        self.dut.address.value = address
        self.dut.read_enable.value = 1
        await self.clock()
        self.dut.read_enable.value = 0
        await self.clock()
        assert self.dut.done.value
        return int(self.dut.read_data.value)


def signed(word: int) -> int:
    """Return bits 17 to 0 of a word as a signed integer, in units of 2⁻¹⁶."""
    return (word & 0x3FFFF ^ 0x20000) - 0x20000


@cocotb.test()
async def words_are_kept_and_limited(dut: Any) -> None:
    window = Window(dut)
    await window.start()
    assert await window.read(SLEW) == 0x10000
    for address, word, kept in (
        (WIDTH, 0xFFFF_FFFF, 0xFF_FFFF),
        (DEAD_ZONE, 0x1234, 0x34),
        (NOMINAL, 0x89AB_CDEF, 0x89AB_CDEF),
        (WORD_A, 70_000, MODULATOR_ONE),
        (WORD_B, -2_000_000_000, -MODULATOR_ONE & 0xFFFF_FFFF),
        (WORD_B, -5, 0xFFFF_FFFB),
        (SLEW, 7, 7),
    ):
        await window.write(address, word)
        assert await window.read(address) == kept
    dut.speed_squared.value = 1234
    assert await window.read(SQUARED) == 1234
    # A read-only word ignores a write.
    await window.write(SPEED, 55)
    assert await window.read(SPEED) == 0


@cocotb.test()
async def words_come_by_slew(dut: Any) -> None:
    """A word moves towards its written target by at most SLEW in each sweep of 144 clocks."""
    window = Window(dut)
    await window.start()
    await window.write(SLEW, 1 << 26)
    await window.write(WORD_A, 30_000)
    while int(dut.sweep_step.value) != AMPLITUDE_SWEEP_CLOCKS - 1:
        await window.clock()
    fine = int(dut.word_a.value) << 16
    for _ in range(40):
        await window.clock(3)
        fine = slewed(fine, 30_000, 1 << 26)
        assert dut.word_a.value.to_signed() == fine >> 16
        await window.clock(AMPLITUDE_SWEEP_CLOCKS - 3)
        assert int(dut.sweep_step.value) == AMPLITUDE_SWEEP_CLOCKS - 1
    assert fine == 30_000 << 16


@cocotb.test()
async def direction_follows_and_is_led_in(dut: Any) -> None:
    """The direction is 0 while unknown; then it moves to 1 by at most SLEW per sweep; after a
    reversal it falls to -1 linearly with the travel."""
    window = Window(dut)
    await window.start()
    width = 400
    await window.write_idle(DEAD_ZONE, 0)
    await window.write(WIDTH, 16 * width)
    await window.write(SLEW, 1 << 28)
    await window.clock(2 * AMPLITUDE_SWEEP_CLOCKS)
    assert dut.direction.value.to_signed() == 0
    assert not await window.read(DIRECTION) & KNOWN
    window.speed = 0.25
    seen = []
    for _ in range(8 * width):
        await window.clock()
        seen.append(dut.direction.value.to_signed())
    assert seen[8 * width - 10] == 0, "the direction changed before the table had moved by 2 W"
    for _ in range(40 * AMPLITUDE_SWEEP_CLOCKS):
        await window.clock()
        seen.append(dut.direction.value.to_signed())
    assert seen[-1] == MODULATOR_ONE
    assert max(b - a for a, b in pairwise(seen)) <= (1 << 12)
    assert await window.read(DIRECTION) == KNOWN | MODULATOR_ONE
    window.speed = -0.25
    turned_at = window.place
    for _ in range(10 * width):
        await window.clock()
        # The direction is up to two sweeps late; at a quarter count per clock the table moves 72
        # counts in that time, and the width is 400 counts.
        way = turned_at - window.place
        now = max(1.0 - way / width, -1.0)
        before = max(1.0 - max(way - 75.0, 0.0) / width, -1.0)
        found = dut.direction.value.to_signed() / MODULATOR_ONE
        assert now - 0.006 <= found <= before + 0.006, (way, found)
    assert dut.direction.value.to_signed() == -MODULATOR_ONE


@cocotb.test()
async def speed_of_a_table(dut: Any) -> None:
    """At constant speed the relative error of the speed ratio is at most one clock per window; at
    standstill the ratio decays to 0."""
    window = Window(dut)
    await window.start()
    nominal = round(0.5 * 2**32)
    await window.write(NOMINAL, nominal)
    for speed in (0.2, 0.01, -0.31):
        window.speed = speed
        await window.clock(6 * WINDOW + round(12 / abs(speed)))
        found = dut.speed.value.to_signed() / MODULATOR_ONE
        assert abs(found - speed / 0.5) <= abs(speed / 0.5) / WINDOW + 2.0**-16
    window.speed = 0.9
    await window.clock(5 * WINDOW)
    assert dut.speed.value.to_signed() == MODULATOR_ONE, "the speed was not limited to 1"
    window.speed = 0.0
    stopped = []
    for _ in range(LONGEST + 4 * AMPLITUDE_SWEEP_CLOCKS):
        await window.clock()
        stopped.append(dut.speed.value.to_signed())
    after = stopped[3 * WINDOW + AMPLITUDE_SWEEP_CLOCKS]
    assert after <= unit_quotient(8 * 2**32, nominal * 2 * WINDOW)
    falls = [a - b for a, b in pairwise(stopped)]
    assert min(falls[WINDOW:]) >= 0
    assert stopped[-1] == 0
    # While the table vibrates over the border between two periods, the speed stays 0.
    edge = 4.0 * (window.place // 4)
    for clock in range(10 * WINDOW):
        window.place = edge + (0.5 if clock // 97 % 2 else -0.5)
        await window.clock()
        assert dut.speed.value.to_signed() == 0


@cocotb.test()
async def a_bank_keeps_its_conditions_until_the_swap(dut: Any) -> None:
    """Written words of the idle bank change nothing before the swap; `idle_speed` is then the speed
    over the nominal speed of the idle bank, and the swap makes it the speed.

    The bound of a ratio is one clock per window, as at constant speed.
    """
    window = Window(dut)
    await window.start()
    nominal = round(0.5 * 2**32)
    width = 100
    await window.write_idle(NOMINAL, nominal)
    await window.write(WIDTH, 16 * width)
    await window.write(SLEW, 0xFFFF_FFFF)
    window.speed = 0.2
    await window.clock(6 * WINDOW + 20 * width)
    h = dut.direction.value.to_signed()
    assert h == MODULATOR_ONE
    for phase in range(0, 3 * AMPLITUDE_SWEEP_CLOCKS, 29):
        await window.clock(phase)
        nominal = nominal * 5 // 4 if phase % 2 else nominal * 3 // 4
        before = dut.speed.value.to_signed()
        await window.write_idle(NOMINAL, nominal)
        assert await window.read(NOMINAL) == nominal
        await window.write_idle(WIDTH, 16 * width)
        written = 0
        while dut.settled.value == 0:
            await window.clock()
            written += 1
        assert 2 * AMPLITUDE_SWEEP_CLOCKS <= written <= 3 * AMPLITUDE_SWEEP_CLOCKS + 1
        speed = 0.2 * 2**32
        assert dut.speed.value.to_signed() == pytest.approx(before, abs=before / WINDOW + 2)
        idle = dut.idle_speed.value.to_signed()
        assert idle / MODULATOR_ONE == pytest.approx(
            speed / nominal, abs=speed / nominal / WINDOW + 2.0**-16
        )
        dut.swap_comes.value = 1
        await window.clock()
        dut.swap_comes.value = 0
        for _ in range(3 * AMPLITUDE_SWEEP_CLOCKS):
            await window.clock()
            assert dut.speed.value.to_signed() == pytest.approx(idle, abs=idle / WINDOW + 2)
        assert dut.direction.value.to_signed() == h
    # A new width makes the direction unknown with the swap, not before.
    await window.write_idle(WIDTH, 16 * width + 1)
    await window.clock(3 * AMPLITUDE_SWEEP_CLOCKS)
    assert await window.read(DIRECTION) & KNOWN
    await window.swap()
    await window.clock(2 * AMPLITUDE_SWEEP_CLOCKS)
    assert not await window.read(DIRECTION) & KNOWN
    # A write waits while a swap waits.
    dut.hold_writes.value = 1
    dut.address.value, dut.write_data.value = NOMINAL, 5
    dut.write_enable.value = 1
    await window.clock()
    dut.write_enable.value = 0
    for _ in range(20):
        await window.clock()
        assert dut.done.value == 0
    dut.hold_writes.value = 0
    await window.clock(2)
    assert dut.done.value == 1
    assert await window.read(NOMINAL) == 5
