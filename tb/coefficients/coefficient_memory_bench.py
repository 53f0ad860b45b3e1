"""Compares coefficient_memory with its model in cocotb tests."""

from __future__ import annotations

import os
import random
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from cocotb.types import Logic

from arctrue.gateware.coefficient_memory import CoefficientMemory, bank_words
from arctrue.gateware.coefficients import Coefficients
from arctrue.generated.number_formats import AMPLITUDE_WIDTH, PHASE_STEP_WIDTH, PHASE_WIDTH

LANES = int(os.environ.get("LANES", "5"))
FOLD = int(os.environ.get("FOLD", "1"))
PHASE_OFFSET_DELAY = int(os.environ.get("PHASE_OFFSET_DELAY", "4"))
AMPLITUDE_DELAY = int(os.environ.get("AMPLITUDE_DELAY", "21"))
OFFSET_DELAY = int(os.environ.get("OFFSET_DELAY", "25"))
LAST_COPY = max(PHASE_OFFSET_DELAY, AMPLITUDE_DELAY, OFFSET_DELAY)
COUNTS_PER_REV = 2**24
WRITE_CLOCKS = 3
# FILLED: number of clocks from a swap until the idle bank is filled. LONGEST_WRITE: largest number
# of clocks from a swap to the acknowledge of a write, from the entity's header.
FILLED = LAST_COPY + 4 * LANES + 2
LONGEST_WRITE = LAST_COPY + 4 * LANES + 5
BUILT = LANES // FOLD
READ_CLOCKS = 2


async def start(dut: Any) -> None:
    for name in ("write_enable", "write_offset", "swap", "write_address", "write_data"):
        getattr(dut, name).value = 0
    dut.read_address.value = 0
    dut.slot.value = 0
    dut.swap_allowed.value = int(FOLD == 1)
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    if FOLD > 1:
        cocotb.start_soon(count_slots(dut))
    # The previous test may have left a swap whose idle bank is still being filled.
    for _ in range(FILLED + 2):
        await RisingEdge(dut.clock)
    dut.reset.value = 0


async def count_slots(dut: Any) -> None:
    """Drive `slot`, which counts from an angle to the next one FOLD clocks later, and
    `swap_allowed`, which is high in the clock before an angle."""
    slot = 0
    while True:
        await RisingEdge(dut.clock)
        slot = (slot + 1) % FOLD
        dut.slot.value = slot
        dut.swap_allowed.value = int(slot == FOLD - 1)


async def next_clock_allows_a_swap(dut: Any) -> None:
    """Wait for the edge after which `swap_allowed` is high."""
    while FOLD > 1 and int(dut.slot.value.to_unsigned()) != FOLD - 2:
        await RisingEdge(dut.clock)


def random_bank(rng: random.Random) -> Coefficients:
    return Coefficients(
        np.array([rng.getrandbits(PHASE_STEP_WIDTH) for _ in range(LANES)], dtype=np.uint64),
        np.array([rng.getrandbits(PHASE_WIDTH) for _ in range(LANES)], dtype=np.uint32),
        np.array([rng.randrange(-(2**24), 2**24) for _ in range(LANES)], dtype=np.int32),
        rng.randrange(-(2**24), 2**24),
        COUNTS_PER_REV,
    )


def flat(words: Any, width: int) -> int:
    return sum((int(word) % 2**width) << (width * lane) for lane, word in enumerate(words))


def outputs(dut: Any) -> tuple[int, int, int, int]:
    """Return the outputs phase steps, phase offsets, amplitudes and offset in the clock that is
    ending."""
    return (
        dut.phase_steps.value.to_unsigned(),
        dut.phase_offsets.value.to_unsigned(),
        dut.amplitudes.value.to_unsigned(),
        dut.offset.value.to_signed(),
    )


DELAYS = (0, PHASE_OFFSET_DELAY, AMPLITUDE_DELAY, OFFSET_DELAY)
"""Number of clocks from an angle until each of the four outputs has the words for its slot 0."""


def expected(bank: Coefficients, block: int = 0) -> tuple[int, int, int, int]:
    """Return the outputs that an angle must get in slot ``block``: the words of this block of
    lanes."""
    lanes = slice(block * BUILT, (block + 1) * BUILT)
    return (
        flat(bank.phase_steps[lanes], PHASE_STEP_WIDTH),
        flat(bank.phase_offsets[lanes], PHASE_WIDTH),
        flat(bank.amplitudes[lanes], AMPLITUDE_WIDTH),
        bank.offset,
    )


def check_met(
    first: int, seen: list[tuple[int, int, int, int]], bank_of_clock: list[Coefficients]
) -> None:
    """Check that every angle gets all its words from one bank.

    ``first`` is the slot of the first clock, ``seen`` has the outputs in each clock, and
    ``bank_of_clock`` the bank from which an angle in this clock must get its words.
    """
    for clock in range(-first % FOLD, len(seen) - LAST_COPY - FOLD, FOLD):
        for slot in range(FOLD):
            met = tuple(seen[clock + slot + delay][part] for part, delay in enumerate(DELAYS[:3]))
            wanted = expected(bank_of_clock[clock], slot)
            assert met == wanted[:3], f"angle of clock {clock}, slot {slot}: a mixed bank"
        assert seen[clock + OFFSET_DELAY][3] == bank_of_clock[clock].offset


async def write(dut: Any, address: int | None, data: int) -> int:
    """Write a word of the idle bank, or the offset if ``address`` is None; return the number of
    clocks until the acknowledge."""
    dut.write_enable.value = int(address is not None)
    dut.write_offset.value = int(address is None)
    dut.write_address.value = address or 0
    dut.write_data.value = data
    await RisingEdge(dut.clock)
    dut.write_enable.value = 0
    dut.write_offset.value = 0
    # The entity stores address and data in the clock of the write; later values at these ports have
    # no effect.
    dut.write_data.value = 0xDEADBEEF
    dut.write_address.value = 255
    for clocks in range(1, LONGEST_WRITE + FOLD + 10):
        await RisingEdge(dut.clock)
        if dut.write_acknowledge.value == 1:
            return clocks
    raise AssertionError("no acknowledge")


async def load(dut: Any, bank: Coefficients) -> None:
    for address, data in bank_words(bank):
        assert await write(dut, address, data) == WRITE_CLOCKS
    assert await write(dut, None, bank.offset % 2**32) == WRITE_CLOCKS


async def start_with_idle_bank(dut: Any, seed: int) -> tuple[random.Random, Coefficients]:
    """Start the test and write a random bank into the idle bank; return the random generator and
    this bank."""
    await start(dut)
    rng = random.Random(seed)
    bank = random_bank(rng)
    await load(dut, bank)
    return rng, bank


async def read(dut: Any, address: int) -> int:
    dut.read_address.value = address
    for _ in range(READ_CLOCKS + 1):
        await RisingEdge(dut.clock)
    return int(dut.read_data.value.to_unsigned())


async def clock_and_see(dut: Any, seen: list[tuple[int, int, int, int]], slots: list[int]) -> None:
    await RisingEdge(dut.clock)
    seen.append(outputs(dut))
    slots.append(int(dut.slot.value.to_unsigned()))


async def check_active(dut: Any, bank: Coefficients) -> None:
    """Check that all angles get the words of ``bank`` while no swap takes place."""
    seen: list[tuple[int, int, int, int]] = []
    slots: list[int] = []
    for _ in range(LAST_COPY + 3 * FOLD):
        await clock_and_see(dut, seen, slots)
    check_met(slots[0], seen, [bank] * len(seen))


@cocotb.test()
async def swap_takes_effect_in_one_clock(dut: Any) -> None:
    """Each part of the bank changes in one clock, after the delay that its stage of the pipeline
    needs."""
    rng, before = await start_with_idle_bank(dut, 1)
    await pulse_swap_and_settle(dut)
    after = random_bank(rng)
    await load(dut, after)
    await next_clock_allows_a_swap(dut)
    dut.swap.value = 1
    seen: list[tuple[int, int, int, int]] = []
    slots: list[int] = []
    markers = []
    for clock in range(FILLED + 4):
        await clock_and_see(dut, seen, slots)
        markers.append(int(dut.swap_marker.value))
        assert int(dut.swap_busy.value) == int(1 <= clock <= FILLED)
        dut.swap.value = 0
    # Clock 0 is the clock of the swap; the first angle that gets the words of the new bank comes
    # with the marker.
    assert [clock for clock, marker in enumerate(markers) if marker] == [1]
    check_met(slots[0], seen, [before] + [after] * (len(seen) - 1))


async def pulse_swap_and_settle(dut: Any) -> None:
    dut.swap.value = 1
    await RisingEdge(dut.clock)
    dut.swap.value = 0
    for _ in range(FILLED + FOLD):
        await RisingEdge(dut.clock)
    assert dut.swap_busy.value == 0


@cocotb.test(skip=FOLD > 1)
async def a_swap_waits_until_it_is_allowed(dut: Any) -> None:
    """While a swap waits, no write reaches the idle bank, and a second request causes no second
    swap."""
    rng, before = await start_with_idle_bank(dut, 5)
    await pulse_swap_and_settle(dut)
    after = random_bank(rng)
    await load(dut, after)
    dut.swap_allowed.value = 0
    for _ in range(2):
        dut.swap.value = 1
        await RisingEdge(dut.clock)
        dut.swap.value = 0
        await RisingEdge(dut.clock)
    dut.write_enable.value = 1
    dut.write_address.value = 0
    dut.write_data.value = 77
    await RisingEdge(dut.clock)
    dut.write_enable.value = 0
    for _ in range(10):
        await RisingEdge(dut.clock)
        assert outputs(dut) == expected(before)
        assert dut.swap_busy.value == 1
        assert dut.write_acknowledge.value == 0
    dut.swap_allowed.value = 1
    markers = 0
    for _ in range(LONGEST_WRITE + 1):
        await RisingEdge(dut.clock)
        markers += int(dut.swap_marker.value)
    assert markers == 1
    assert outputs(dut) == expected(after)
    assert await read(dut, 0) == 77


@cocotb.test()
async def swaps_one_after_the_other(dut: Any) -> None:
    """A swap that is requested while the idle bank is being filled waits; no word of an earlier
    bank becomes active again."""
    _, bank = await start_with_idle_bank(dut, 6)
    markers = 0
    for clock in range(2 * (FILLED + FOLD) + 10):
        dut.swap.value = int(clock in (0, 3, FILLED // 2))
        await RisingEdge(dut.clock)
        markers += int(dut.swap_marker.value)
    assert markers == 2
    await check_active(dut, bank)


@cocotb.test()
async def read_back_shows_what_is_stored(dut: Any) -> None:
    """The memory stores neither bits outside the formats nor words of lanes beyond LANES."""
    await start(dut)
    rng = random.Random(2)
    model = CoefficientMemory(COUNTS_PER_REV, LANES)
    # The memory keeps the words of the previous test of this simulation, so write every word.
    for address in rng.sample(range(256), 256):
        data = rng.getrandbits(32)
        await write(dut, address, data)
        model.write(address, data)
    offset = rng.getrandbits(32)
    await write(dut, None, offset)
    model.write_offset(offset)
    for address in range(256):
        found = await read(dut, address)
        assert found == model.read(address), f"address {address}"
    await pulse_swap_and_settle(dut)
    model.swap()
    await check_active(dut, model.active)
    assert dut.idle_offset.value.to_signed() == model.active.offset
    # The idle bank still holds all words, so change one word and swap again.
    await write(dut, 3, 12345)
    model.write(3, 12345)
    await pulse_swap_and_settle(dut)
    model.swap()
    await check_active(dut, model.active)
    assert await read(dut, 3) == 12345


@cocotb.test()
async def every_angle_meets_one_bank(dut: Any) -> None:
    """Each angle gets words that the idle bank held all at the same time, while swaps and writes
    come at random instants."""
    await start(dut)
    rng = random.Random(3)
    model = CoefficientMemory(COUNTS_PER_REV, LANES)
    model.load(random_bank(rng))
    await load(dut, model.active)
    await pulse_swap_and_settle(dut)
    clocks = 50 * FILLED
    seen: list[tuple[int, int, int, int]] = []
    slots: list[int] = []
    bank_of_clock: list[Coefficients] = []
    pending: tuple[int | None, int] | None = None
    longest_wait = waiting = asked = met = 0
    last = clock_of_swap = -1
    for clock in range(clocks):
        swap = rng.random() < 0.6 / FILLED
        dut.swap.value = int(swap)
        starts = pending is None and rng.random() < 0.5
        if starts:
            pending = (
                None if rng.random() < 0.1 else rng.randrange(4 * LANES),
                rng.getrandbits(32),
            )
            waiting = 0
        address, data = pending or (0, 0)
        dut.write_enable.value = int(starts and address is not None)
        dut.write_offset.value = int(starts and address is None)
        dut.write_address.value = address or 0
        dut.write_data.value = data
        await clock_and_see(dut, seen, slots)
        if dut.swap_marker.value == 1:
            # The idle bank was filled before the swap was requested, so the swap activates all
            # acknowledged words.
            assert asked
            assert last < 0 or clock - last >= FILLED
            assert clock - max(clock_of_swap, last + FILLED) <= FOLD + 2
            model.swap()
            asked, last, met = 0, clock, met + 1
            waiting = 0
        bank_of_clock.append(model.active)
        if swap and not asked:
            asked, clock_of_swap = 1, clock
        waiting += 1
        if dut.write_acknowledge.value == 1:
            assert pending is not None
            longest_wait = max(longest_wait, waiting)
            if address is None:
                model.write_offset(data)
            else:
                model.write(address, data)
            pending = None
    assert met > 15
    # The clocks of a write count from its start, or from the previous swap if that is later.
    assert FILLED < longest_wait <= LONGEST_WRITE
    check_met(slots[0], seen, bank_of_clock)


@cocotb.test()
async def reset_leaves_whole_banks(dut: Any) -> None:
    """A reset during a swap drops only the pending write; no bank gets a mixture of words."""
    _, bank = await start_with_idle_bank(dut, 4)
    await next_clock_allows_a_swap(dut)
    dut.swap.value = 1
    await RisingEdge(dut.clock)
    dut.swap.value = 0
    dut.write_enable.value = 1
    dut.write_address.value = 2
    dut.write_data.value = 1 + int(bank.phase_offsets[0]) % 1000
    await RisingEdge(dut.clock)
    dut.write_enable.value = 0
    dut.reset.value = 1
    await RisingEdge(dut.clock)
    dut.reset.value = 0
    for _ in range(FILLED + FOLD + 5):
        await RisingEdge(dut.clock)
        assert dut.write_acknowledge.value == 0
    await check_active(dut, bank)
    assert await read(dut, 2) == int(bank.phase_offsets[0])


@cocotb.test()
async def a_reset_drops_a_swap_that_waits(dut: Any) -> None:
    """A swap that waits during the fill after an earlier swap does not take place after a
    reset."""
    _, active = await start_with_idle_bank(dut, 7)
    await next_clock_allows_a_swap(dut)
    markers = 0
    for clock in range(2 * (FILLED + FOLD) + 10):
        dut.swap.value = int(clock in (0, 1))
        dut.reset.value = int(clock == 3)
        await RisingEdge(dut.clock)
        markers += int(dut.swap_marker.value)
    assert markers == 1
    assert dut.swap_busy.value == 0
    await check_active(dut, active)


@cocotb.test()
async def a_reset_ends_an_undefined_swap(dut: Any) -> None:
    """Writes and swaps work after a reset in which the level of `swap` was undefined, as in a
    simulation in which the register with `swap` has no initial value."""
    await start(dut)
    dut.reset.value = 1
    dut.swap.value = Logic("X")
    for _ in range(2 * FOLD + 2):
        await RisingEdge(dut.clock)
    dut.swap.value = 0
    # The undefined level leaves the entity as a swap does, with the last of the four outputs.
    for _ in range(LAST_COPY + 2):
        await RisingEdge(dut.clock)
    dut.reset.value = 0
    bank = random_bank(random.Random(8))
    await load(dut, bank)
    await pulse_swap_and_settle(dut)
    await check_active(dut, bank)
