"""Compares a compensation_pipeline for real orders with its model, clock by clock, in cocotb."""

from __future__ import annotations

import dataclasses
import random
from typing import Any

import cocotb
import numpy as np
from cocotb.triggers import RisingEdge
from numpy.typing import NDArray

from arctrue.gateware.coefficient_memory import bank_words, turn_step_words
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.compensation_pipeline import compensate, compensate_clocks
from arctrue.gateware.lane_words import phase_step
from arctrue.gateware.turn_counter import turn_numbers
from arctrue.generated.number_formats import (
    PHASE_STEP_WIDTH,
    PHASE_WIDTH,
    TURN_SWEEP_CLOCKS_A_LANE,
)
from tb.core.compensation_pipeline_bench import (
    COUNTS_PER_REV,
    FOLD,
    LANES,
    LATENCY,
    RATE_MAX,
    align,
    outputs,
    start,
)

TURN = 1 << PHASE_STEP_WIDTH
SWEEP_CLOCKS = TURN_SWEEP_CLOCKS_A_LANE * LANES
HALF_ORDERS = (0.5, 71.4, 3.0, 0.398, 70.4, 7.875, 12.5, 1.0)
"""Orders of a belt, of a gear with a side harmonic, of a bearing's cage, and four other orders, two
of them integers."""


def bank_of(
    seed: int, orders: tuple[float, ...] = HALF_ORDERS, largest_counts: int = 60
) -> Coefficients:
    """Return a bank with lanes of these orders; its words are those that a coefficient file would
    contain."""
    rng = np.random.default_rng(seed)
    of_lanes = [orders[lane % len(orders)] for lane in range(LANES)]
    steps = tuple(round(order % 1 * TURN) for order in of_lanes)
    return Coefficients(
        np.array([round(order * TURN / COUNTS_PER_REV) for order in of_lanes], dtype=np.uint64),
        rng.integers(0, 1 << PHASE_WIDTH, LANES),
        rng.integers(largest_counts * 700, largest_counts * 2048, LANES),
        0,
        COUNTS_PER_REV,
        None,
        Extension(turn_steps=tuple((lane, step) for lane, step in enumerate(steps) if step)),
    )


async def write(dut: Any, address: int, data: int, *, turn_step: bool) -> None:
    dut.write_enable.value = int(not turn_step)
    dut.write_turn_step.value = int(turn_step)
    dut.write_address.value = address
    dut.write_data.value = data
    await RisingEdge(dut.clock)
    dut.write_enable.value = 0
    dut.write_turn_step.value = 0
    while dut.write_acknowledge.value != 1:
        await RisingEdge(dut.clock)


async def load(dut: Any, bank: Coefficients) -> int:
    """Write all words of ``bank`` and swap; return the clocks until the new bank is in use."""
    for address, data in bank_words(bank):
        await write(dut, address, data, turn_step=False)
    for address, data in turn_step_words(bank):
        await write(dut, address, data, turn_step=True)
    dut.swap.value = 1
    await RisingEdge(dut.clock)
    dut.swap.value = 0
    waited = 0
    while dut.swap_done.value != 1:
        await RisingEdge(dut.clock)
        waited += 1
    return waited - LATENCY


async def settle(dut: Any) -> None:
    while True:
        for _ in range(LATENCY + 4 * SWEEP_CLOCKS):
            await RisingEdge(dut.clock)
        if dut.ramp_busy.value == 0 and dut.swap_busy.value == 0:
            return


async def begin(dut: Any) -> None:
    dut.write_turn_step.value = 0
    dut.read_turn_step.value = 0
    await start(dut)
    dut.apply.value = 1


async def play(dut: Any, total: NDArray[np.int64]) -> NDArray[np.int64]:
    """Drive the angles of many turns, one every FOLD clocks; return the outputs after the
    latency."""
    await align(dut)
    seen = []
    for clock in range(FOLD * total.size + LATENCY):
        now = total[min(clock // FOLD, total.size - 1)]
        dut.angle.value = int(now % COUNTS_PER_REV)
        dut.position.value = int(now)
        await RisingEdge(dut.clock)
        seen.append(outputs(dut))
    return np.array(seen[LATENCY::FOLD][: total.size], dtype=np.int64)


def motions(rng: np.random.Generator, size: int) -> NDArray[np.int64]:
    """Return positions: forwards over a wrap, vibration over the second wrap, and backwards over
    four wraps."""
    fastest = np.arange(0, int(1.95 * COUNTS_PER_REV), FOLD)
    to_wrap = np.arange(fastest[-1], 2 * COUNTS_PER_REV, max(1, FOLD // 2))
    tremble = 2 * COUNTS_PER_REV + rng.integers(-2, 3, size)
    back = np.arange(2 * COUNTS_PER_REV, -COUNTS_PER_REV - 50, -FOLD)
    return np.concatenate([fastest, to_wrap, tremble, back]).astype(np.int64)


@cocotb.test()
async def both_ways_and_tremble(dut: Any) -> None:
    """At one count per clock every correction equals the model's and is near the sum of the
    harmonics in float64."""
    await begin(dut)
    bank = bank_of(1)
    dut.angle.value = dut.position.value = 0
    await load(dut, bank)
    await settle(dut)
    assert dut.turn.value.to_signed() == 0
    total = motions(np.random.default_rng(2), 400)
    found = await play(dut, total)
    angles = total % COUNTS_PER_REV
    turns = turn_numbers(angles, COUNTS_PER_REV)
    assert np.array_equal(turns, total // COUNTS_PER_REV)
    model = compensate(angles, total, bank, turns=turns)
    assert np.array_equal(found, np.column_stack(model))
    # The sum of the harmonics in float64 is computed from the unwrapped position, so it has no step
    # at a wrap and no drift.
    line = np.zeros(total.size)
    for lane in range(LANES):
        cycles = HALF_ORDERS[lane % len(HALF_ORDERS)] * (total / COUNTS_PER_REV)
        phase = 2.0 * np.pi * (cycles + bank.phase_offsets[lane] / 2.0**PHASE_WIDTH)
        line += bank.amplitudes_counts[lane] * np.cos(phase)
    # The errors of CORDIC and phase are together below 2⁻¹³ of each amplitude.
    assert np.abs(found[:, 2] / 2048 - line).max() < bank.amplitudes_counts.sum() * 2.0**-13


@cocotb.test()
async def whole_orders_as_without(dut: Any) -> None:
    """Lanes without a turn step give the correction of a core without REAL_ORDERS in every turn."""
    await begin(dut)
    bank = bank_of(3, (1.0, 2.0, 5.0, 31.0))
    dut.angle.value = dut.position.value = 0
    await load(dut, bank)
    await settle(dut)
    total = np.arange(0, -COUNTS_PER_REV - 100, -FOLD)
    found = await play(dut, total)
    assert np.array_equal(found, np.column_stack(compensate(total % COUNTS_PER_REV, total, bank)))


@cocotb.test()
async def zero_moves_and_heals(dut: Any) -> None:
    """If the angle jumps by lost counts, even over the wrap, the phases of the harmonics advance by
    these counts."""
    await begin(dut)
    bank = bank_of(4, largest_counts=9)
    dut.angle.value = dut.position.value = 0
    await load(dut, bank)
    await settle(dut)
    rng = np.random.default_rng(5)
    here, parts = 0, []
    for slip in (7, -COUNTS_PER_REV // 3):
        way = 1 if slip > 0 else -1
        part = here + way * FOLD * np.arange(1, int(1.1 * COUNTS_PER_REV) // FOLD)
        # Move to a few counts before a wrap, so that the slip crosses the wrap.
        part = part[: np.flatnonzero((part + slip) // COUNTS_PER_REV != part // COUNTS_PER_REV)[-1]]
        part = np.concatenate([part, np.full(40, part[-1])])
        parts.append(part)
        here = int(part[-1]) + slip
    total = np.concatenate([*parts, here + rng.integers(-3, 4, 1000)])
    toggles = np.zeros(total.size, dtype=bool)
    ends = np.cumsum([part.size for part in parts])
    for end in ends:
        toggles[end:] ^= True
    await align(dut)
    seen = []
    for clock in range(FOLD * total.size + LATENCY):
        place = min(clock // FOLD, total.size - 1)
        dut.angle.value = int(total[place] % COUNTS_PER_REV)
        dut.position.value = int(total[place])
        dut.zero_moved.value = int(toggles[place])
        await RisingEdge(dut.clock)
        seen.append((*outputs(dut), int(dut.ramp_busy.value)))
    found = np.array(seen[LATENCY::FOLD][: total.size], dtype=np.int64)
    model = compensate(
        total % COUNTS_PER_REV,
        total,
        bank,
        turns=turn_numbers(total % COUNTS_PER_REV, COUNTS_PER_REV),
    )
    # Whenever the ramp has absorbed a jump, every output equals the model's.
    settled = found[:, 3] == 0
    assert settled[: ends[0]].all()
    assert np.array_equal(found[settled, :3], np.column_stack(model)[settled])
    assert (settled[1:] & ~settled[:-1]).sum() == len(parts)


@cocotb.test()
async def swaps_at_any_moment(dut: Any) -> None:
    """Each angle is corrected with the words of one bank, while writes and swaps come at random
    instants of a motion."""
    await begin(dut)
    choose, rng = random.Random(6), np.random.default_rng(6)
    banks = [bank_of(10, largest_counts=2)]
    dut.angle.value = dut.position.value = 0
    await load(dut, banks[0])
    await settle(dut)
    total = motions(rng, 200)
    words: list[tuple[int, int, bool]] = []
    pending = asked = False
    await align(dut)
    seen, done = [], []
    for clock in range(FOLD * total.size + LATENCY):
        now = total[min(clock // FOLD, total.size - 1)]
        dut.angle.value = int(now % COUNTS_PER_REV)
        dut.position.value = int(now)
        dut.swap.value = 0
        dut.write_enable.value = dut.write_turn_step.value = 0
        if not words and not pending and not asked and clock > 1000 and choose.random() < 0.02:
            orders = tuple(choose.uniform(0.0, 90.0) for _ in range(LANES))
            banks.append(bank_of(clock, orders, 2))
            words = [(*entry, False) for entry in bank_words(banks[-1])]
            words += [(*entry, True) for entry in turn_step_words(banks[-1])]
            choose.shuffle(words)
            asked = True
        elif words and not pending:
            address, data, is_step = words.pop()
            dut.write_enable.value = int(not is_step)
            dut.write_turn_step.value = int(is_step)
            dut.write_address.value = address
            dut.write_data.value = data
            pending = True
        elif asked and not words and not pending:
            dut.swap.value = 1
            asked = False
        await RisingEdge(dut.clock)
        if dut.write_acknowledge.value == 1:
            pending = False
        seen.append(outputs(dut))
        done.append(int(dut.swap_done.value))
    found = np.array(seen[LATENCY:], dtype=np.int64)
    markers = np.array(done[LATENCY:], dtype=bool)
    assert markers.sum() >= 5
    met = np.cumsum(markers)
    applied = np.ones(markers.size, dtype=bool)
    clocks = np.arange(markers.size) // FOLD
    angles = total[clocks] % COUNTS_PER_REV
    turns = turn_numbers(total % COUNTS_PER_REV, COUNTS_PER_REV)[clocks]
    model = compensate_clocks(
        angles,
        total[clocks],
        banks[: met[-1] + 1],
        met,
        markers,
        applied,
        RATE_MAX,
        fold=FOLD,
        turns=turns,
    )
    # The model starts from a reset, but the gateware has already settled, so they differ until the
    # model has settled too.
    settled = np.arange(markers.size) >= 900
    assert np.flatnonzero(markers)[0] > 900
    apart = np.flatnonzero((found != np.column_stack(model[:3])).any(axis=1) & settled)
    assert not apart.size, (apart[:5], apart.size, np.flatnonzero(markers))


@cocotb.test()
async def read_back_and_fill(dut: Any) -> None:
    """All words can be read back; after a swap the bank that was filled gives the same correction,
    in the next turn too."""
    await begin(dut)
    bank = bank_of(7)
    await load(dut, bank)
    await settle(dut)
    for words, is_step in ((bank_words(bank), 0), (turn_step_words(bank), 1)):
        for address, data in words:
            dut.read_address.value = address
            dut.read_turn_step.value = is_step
            for _ in range(3):
                await RisingEdge(dut.clock)
            assert int(dut.read_data.value) == data
    dut.read_turn_step.value = 0
    dut.angle.value = dut.position.value = 0
    dut.swap.value = 1
    await RisingEdge(dut.clock)
    dut.swap.value = 0
    await settle(dut)
    total = np.arange(0, COUNTS_PER_REV + 100, FOLD)
    found = await play(dut, total)
    model = compensate(total % COUNTS_PER_REV, total, bank, turns=total // COUNTS_PER_REV)
    assert np.array_equal(found, np.column_stack(model))


@cocotb.test()
async def a_swap_waits_for_the_sweep(dut: Any) -> None:
    """A swap waits for two sweeps after the last write, as the header of the memory states."""
    await begin(dut)
    waited = await load(dut, bank_of(8))
    assert 2 * SWEEP_CLOCKS - 8 <= waited <= 2 * SWEEP_CLOCKS + 12 + FOLD
    assert phase_step(1, COUNTS_PER_REV) == round(TURN / COUNTS_PER_REV)
    assert dataclasses.replace(bank_of(8)).turn_steps.any()
