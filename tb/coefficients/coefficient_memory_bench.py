"""cocotb tests of coefficient_memory against its model."""

from __future__ import annotations

import os
import random
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.coefficient_memory import CoefficientMemory, bank_words
from arctrue.gateware.coefficients import Coefficients
from arctrue.generated.number_formats import AMPLITUDE_WIDTH, PHASE_STEP_WIDTH, PHASE_WIDTH

LANES = int(os.environ.get("LANES", "5"))
PHASE_OFFSET_DELAY = int(os.environ.get("PHASE_OFFSET_DELAY", "4"))
AMPLITUDE_DELAY = int(os.environ.get("AMPLITUDE_DELAY", "21"))
OFFSET_DELAY = int(os.environ.get("OFFSET_DELAY", "25"))
LAST_COPY = max(PHASE_OFFSET_DELAY, AMPLITUDE_DELAY, OFFSET_DELAY)
COUNTS_PER_REV = 2**24
WRITE_CLOCKS = 2
READ_CLOCKS = 2


async def start(dut: Any) -> None:
    for name in ("write_enable", "write_offset", "swap", "write_address", "write_data"):
        getattr(dut, name).value = 0
    dut.read_address.value = 0
    dut.swap_allowed.value = 1
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(2):
        await RisingEdge(dut.clock)
    dut.reset.value = 0


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
    """The four parts of the active bank in the clock that is ending."""
    return (
        dut.phase_steps.value.to_unsigned(),
        dut.phase_offsets.value.to_unsigned(),
        dut.amplitudes.value.to_unsigned(),
        dut.offset.value.to_signed(),
    )


def expected(bank: Coefficients) -> tuple[int, int, int, int]:
    return (
        flat(bank.phase_steps, PHASE_STEP_WIDTH),
        flat(bank.phase_offsets, PHASE_WIDTH),
        flat(bank.amplitudes, AMPLITUDE_WIDTH),
        bank.offset,
    )


async def write(dut: Any, address: int | None, data: int) -> int:
    """Write a word (or the offset); returns the clocks until the acknowledge."""
    dut.write_enable.value = int(address is not None)
    dut.write_offset.value = int(address is None)
    dut.write_address.value = address or 0
    dut.write_data.value = data
    await RisingEdge(dut.clock)
    dut.write_enable.value = 0
    dut.write_offset.value = 0
    # What the write carries is taken over in its own clock.
    dut.write_data.value = 0xDEADBEEF
    dut.write_address.value = 255
    for clocks in range(1, LAST_COPY + 10):
        await RisingEdge(dut.clock)
        if dut.write_acknowledge.value == 1:
            return clocks
    raise AssertionError("no acknowledge")


async def load(dut: Any, bank: Coefficients) -> None:
    for address, data in bank_words(bank):
        assert await write(dut, address, data) == WRITE_CLOCKS
    assert await write(dut, None, bank.offset % 2**32) == WRITE_CLOCKS


async def read(dut: Any, address: int) -> int:
    dut.read_address.value = address
    for _ in range(READ_CLOCKS + 1):
        await RisingEdge(dut.clock)
    return int(dut.read_data.value.to_unsigned())


@cocotb.test()
async def swap_takes_effect_in_one_clock(dut: Any) -> None:
    """Each part changes as a whole, with the delay of its place in the pipeline."""
    await start(dut)
    rng = random.Random(1)
    before = random_bank(rng)
    await load(dut, before)
    await pulse_swap_and_settle(dut)
    after = random_bank(rng)
    await load(dut, after)
    assert outputs(dut) == expected(before)
    dut.swap.value = 1
    seen = []
    markers = []
    for clock in range(LAST_COPY + 4):
        await RisingEdge(dut.clock)
        seen.append(outputs(dut))
        markers.append(int(dut.swap_marker.value))
        assert int(dut.swap_busy.value) == int(1 <= clock <= LAST_COPY)
        dut.swap.value = 0
    # Clock 0 is that of the swap; the first angle of the new bank comes with the marker.
    assert [clock for clock, marker in enumerate(markers) if marker] == [1]
    delays = (0, PHASE_OFFSET_DELAY, AMPLITUDE_DELAY, OFFSET_DELAY)
    for part, delay in enumerate(delays):
        old, new = expected(before)[part], expected(after)[part]
        assert [clock[part] for clock in seen] == [
            new if clock >= 1 + delay else old for clock in range(len(seen))
        ]


async def pulse_swap_and_settle(dut: Any) -> None:
    dut.swap.value = 1
    await RisingEdge(dut.clock)
    dut.swap.value = 0
    for _ in range(LAST_COPY + 2):
        await RisingEdge(dut.clock)


@cocotb.test()
async def a_swap_waits_until_it_is_allowed(dut: Any) -> None:
    """Meanwhile no write reaches the idle bank, and another swap joins the one that waits."""
    await start(dut)
    rng = random.Random(5)
    before, after = random_bank(rng), random_bank(rng)
    await load(dut, before)
    await pulse_swap_and_settle(dut)
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
    for _ in range(LAST_COPY + 3):
        await RisingEdge(dut.clock)
        markers += int(dut.swap_marker.value)
    assert markers == 1
    assert outputs(dut) == expected(after)
    assert await read(dut, 0) == 77


@cocotb.test()
async def read_back_shows_what_is_stored(dut: Any) -> None:
    """Bits outside the formats and lanes that are not built are not stored."""
    await start(dut)
    rng = random.Random(2)
    model = CoefficientMemory(COUNTS_PER_REV, LANES)
    # A simulation run keeps the state of the test before: write every word.
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
    assert outputs(dut) == expected(model.active)
    assert dut.idle_offset.value.to_signed() == model.active.offset
    # The idle bank still holds it all: change one word and swap again.
    await write(dut, 3, 12345)
    model.write(3, 12345)
    await pulse_swap_and_settle(dut)
    model.swap()
    assert outputs(dut) == expected(model.active)
    assert await read(dut, 3) == 12345


@cocotb.test()
async def every_angle_meets_one_bank(dut: Any) -> None:
    """Swaps and writes at random instants: an angle meets one snapshot of the idle bank."""
    await start(dut)
    rng = random.Random(3)
    model = CoefficientMemory(COUNTS_PER_REV, LANES)
    model.load(random_bank(rng))
    await load(dut, model.active)
    await pulse_swap_and_settle(dut)
    clocks = 3000
    seen: list[tuple[int, int, int, int]] = []
    bank_of_clock: list[tuple[int, int, int, int]] = []
    active = expected(model.active)
    pending: tuple[int | None, int] | None = None
    longest_wait = waiting = 0
    for _ in range(clocks):
        swap = rng.random() < 0.03
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
        await RisingEdge(dut.clock)
        seen.append(outputs(dut))
        bank_of_clock.append(active)
        waiting += 1
        if dut.write_acknowledge.value == 1:
            assert pending is not None
            longest_wait = max(longest_wait, waiting)
            if address is None:
                model.write_offset(data)
            else:
                model.write(address, data)
            pending = None
        if swap:
            model.swap()
            active = expected(model.active)
    assert len(set(bank_of_clock)) > 30
    assert longest_wait > LAST_COPY
    for clock in range(clocks - LAST_COPY):
        met = (
            seen[clock][0],
            seen[clock + PHASE_OFFSET_DELAY][1],
            seen[clock + AMPLITUDE_DELAY][2],
            seen[clock + OFFSET_DELAY][3],
        )
        assert met == bank_of_clock[clock], f"angle of clock {clock} meets a mixed bank"


@cocotb.test()
async def reset_leaves_whole_banks(dut: Any) -> None:
    """A reset in the midst of a copy drops the pending write and nothing else."""
    await start(dut)
    rng = random.Random(4)
    bank = random_bank(rng)
    await load(dut, bank)
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
    for _ in range(LAST_COPY + 5):
        await RisingEdge(dut.clock)
        assert dut.write_acknowledge.value == 0
    assert outputs(dut) == expected(bank)
    assert await read(dut, 2) == int(bank.phase_offsets[0])
