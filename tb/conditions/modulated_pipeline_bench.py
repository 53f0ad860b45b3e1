"""Compares a modulated compensation_pipeline with its model, clock by clock, in cocotb."""

from __future__ import annotations

import os
import random
from typing import Any

import cocotb
import numpy as np
from cocotb.triggers import RisingEdge

from arctrue.gateware.amplitude_sweep import Modulators, effective_amplitudes, modulated
from arctrue.gateware.coefficient_memory import bank_words
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.compensation_pipeline import compensate
from arctrue.gateware.error_compensation import add_pairs, correction_limit, subtract
from arctrue.gateware.extension import MODULATORS, Conditions
from arctrue.gateware.harmonic_unit import harmonic_unit
from arctrue.gateware.phase_unit import phase_unit
from arctrue.gateware.table_conditions import MODULATOR_ONE
from arctrue.generated.number_formats import (
    AMPLITUDE_CLOCK,
    AMPLITUDE_SWEEP_CLOCKS,
    PAIR_FRACTION,
    PHASE_LATENCY,
)
from tb.core.compensation_pipeline_bench import (
    COUNTS_PER_REV,
    FOLD,
    LANES,
    LATENCY,
    align,
    outputs,
    start,
    write,
)

ANGLES = 1200
SWAPS = int(os.environ["SWAPS"])
# WRITE_CLOCKS: number of clocks from a step of the sweep to the first read that returns the word
# which this step writes.
WRITE_CLOCKS = 6
# READ_CLOCKS: number of clocks from an angle to the clock in which its amplitude is read.
READ_CLOCKS = PHASE_LATENCY + AMPLITUDE_CLOCK - 1
NAMES = ("direction", "speed", "word_a", "word_b")


def bank_of(seed: int) -> Coefficients:
    """Return a bank whose lanes have each modulator or none; lane 0 has order 0."""
    rng = np.random.default_rng(seed)
    orders = rng.integers(0, 90, LANES)
    orders[0] = 0
    conditions = Conditions(160, 4, 90.0)
    followed = tuple((lane, MODULATORS[1 + lane % 5]) for lane in range(LANES) if lane % 6 < 5)
    bank = Coefficients.from_harmonics(
        orders,
        rng.uniform(20.0, 80.0, LANES),
        rng.uniform(-np.pi, np.pi, LANES),
        COUNTS_PER_REV,
        LANES,
    )
    return Coefficients(
        bank.phase_steps,
        bank.phase_offsets,
        bank.amplitudes,
        0,
        COUNTS_PER_REV,
        None,
        Extension(conditions=conditions, modulators=followed),
    )


class Sweep:
    """Drives the step of the sweep and the modulators in every clock, and records them."""

    def __init__(self, dut: Any, seed: int) -> None:
        self.dut = dut
        self.choose = random.Random(seed)
        self.now = Modulators()
        self.moves = False
        self.clock = 0
        self.steps: list[int] = []
        self.held: list[Modulators] = []
        """Modulators at the last step of each sweep, in the order of the sweeps."""

    def put(self, modulators: Modulators, idle_speed: int | None = None) -> None:
        """Drive the modulators; the idle bank has the speed ``idle_speed`` (None: the same)."""
        self.now = modulators
        for name in NAMES:
            getattr(self.dut, name).value = getattr(modulators, name)
        self.dut.idle_speed.value = modulators.speed if idle_speed is None else idle_speed

    def random(self) -> Modulators:
        one = MODULATOR_ONE
        return Modulators(*(self.choose.randint(-one, one) for _ in NAMES))

    async def run(self) -> None:
        step = 0
        self.put(self.now)
        while True:
            self.dut.sweep_step.value = step
            self.steps.append(step)
            if step == AMPLITUDE_SWEEP_CLOCKS - 1:
                self.held.append(self.now)
            await RisingEdge(self.dut.clock)
            self.clock += 1
            step = (step + 1) % AMPLITUDE_SWEEP_CLOCKS
            if self.moves and step == 7:
                self.put(self.random())

    async def load(self, bank: Coefficients) -> int:
        """Write all words of ``bank`` and swap; return the clocks until the new bank is in use."""
        for address, data in bank_words(bank):
            await write(self.dut, address, data)
        self.dut.swap.value = 1
        await RisingEdge(self.dut.clock)
        self.dut.swap.value = 0
        waited = 0
        while self.dut.swap_done.value != 1:
            await RisingEdge(self.dut.clock)
            waited += 1
        return waited - LATENCY

    async def settle(self) -> None:
        while True:
            for _ in range(LATENCY + 3 * AMPLITUDE_SWEEP_CLOCKS):
                await RisingEdge(self.dut.clock)
            if self.dut.ramp_busy.value == 0 and self.dut.swap_busy.value == 0:
                return


async def begin(dut: Any, seed: int) -> Sweep:
    sweep = Sweep(dut, seed)
    dut.sweep_step.value = 0
    await start(dut)
    cocotb.start_soon(sweep.run())
    dut.apply.value = 1
    return sweep


@cocotb.test()
async def held_modulators(dut: Any) -> None:
    """With constant modulators, the outputs equal those of lanes without modulators whose
    amplitudes are multiplied by the modulators, for each FOLD."""
    sweep = await begin(dut, 1)
    rng = np.random.default_rng(3)
    one = MODULATOR_ONE
    for number, held in enumerate((Modulators(one, -one, one, -one), sweep.random())):
        bank = bank_of(number)
        sweep.put(held)
        dut.angle.value = 0
        waited = await sweep.load(bank)
        # The swap waits for the end of the present sweep and for one more sweep; the clocks until
        # the acknowledge of the last write are subtracted.
        assert AMPLITUDE_SWEEP_CLOCKS - 8 <= waited <= 2 * AMPLITUDE_SWEEP_CLOCKS + FOLD + 8
        await sweep.settle()
        angles = rng.integers(0, COUNTS_PER_REV, 150)
        await align(dut)
        seen = []
        for clock in range(FOLD * angles.size + LATENCY):
            now = min(clock // FOLD, angles.size - 1)
            dut.angle.value = dut.position.value = int(angles[now])
            await RisingEdge(dut.clock)
            seen.append(outputs(dut))
        found = np.array(seen[LATENCY::FOLD][: angles.size])
        model = compensate(angles, angles, modulated(bank, held))
        assert np.array_equal(found, np.column_stack(model))
        assert np.ptp(found[:, 2]) > 40 * 2048


@cocotb.test()
async def the_read_back_is_nominal(dut: Any) -> None:
    """Words that are read back equal the written words, even after a swap has copied them to the
    idle bank."""
    sweep = await begin(dut, 2)
    bank = bank_of(5)
    sweep.put(sweep.random())
    await sweep.load(bank)
    await sweep.settle()
    for address, data in bank_words(bank):
        dut.read_address.value = address
        for _ in range(3):
            await RisingEdge(dut.clock)
        assert int(dut.read_data.value) == data
    # Both banks then have equal words, so the outputs do not change.
    dut.angle.value = dut.position.value = COUNTS_PER_REV // 3
    await sweep.settle()
    before = outputs(dut)
    dut.swap.value = 1
    await RisingEdge(dut.clock)
    dut.swap.value = 0
    await sweep.settle()
    assert outputs(dut) == before


RAMP_RATE = 16 << 24
"""Rate of the ramp in the test below: 16 units of 2⁻¹¹ count per clock."""


@cocotb.test()
async def a_swap_with_another_nominal_speed(dut: Any) -> None:
    """A bank with another nominal speed begins with its own ratio: at the swap and after it the
    correction changes by no more than the ramp's rate, and it ends at the model's value.

    The swap comes in another clock of the sweep each time. The bound is the rate of the ramp for
    the FOLD clocks of an angle, and a unit for the truncation of the output.
    """
    sweep = await begin(dut, 7)
    dut.ramp_rate.value = RAMP_RATE
    dut.angle.value = dut.position.value = 777
    await sweep.settle()
    for number in range(SWAPS):
        bank = bank_of(number)
        speed = sweep.random().speed
        sweep.put(sweep.now, idle_speed=speed)
        for address, data in bank_words(bank):
            await write(dut, address, data)
        for _ in range(13 * number + 3 * AMPLITUDE_SWEEP_CLOCKS):
            await RisingEdge(dut.clock)
        dut.swap.value = 1
        await RisingEdge(dut.clock)
        dut.swap.value = 0
        before = outputs(dut)[2]
        while dut.swap_comes.value != 1:
            await RisingEdge(dut.clock)
        await RisingEdge(dut.clock)
        # table_conditions makes the idle speed the speed in the clock after swap_comes.
        sweep.put(sweep.now._replace(speed=speed))
        for _ in range(4 * AMPLITUDE_SWEEP_CLOCKS):
            await RisingEdge(dut.clock)
            now = outputs(dut)[2]
            assert abs(now - before) <= (RAMP_RATE >> 24) * FOLD + 1, (number, before, now)
            before = now
        dut.ramp_rate.value = 0xFFFF_FFFF
        await sweep.settle()
        dut.ramp_rate.value = RAMP_RATE
        expected = compensate(np.array([777]), np.array([777]), modulated(bank, sweep.now))
        assert outputs(dut) == tuple(int(column[0]) for column in expected)


@cocotb.test()
async def moving_modulators(dut: Any) -> None:
    """Each angle is corrected with the amplitudes that the sweep had written when the pipeline read
    them."""
    sweep = await begin(dut, 4)
    bank = bank_of(9)
    dut.angle.value = 0
    await sweep.load(bank)
    await sweep.settle()
    sweep.moves = True
    await align(dut)
    near = sweep.clock
    rng = np.random.default_rng(6)
    angles = np.cumsum(rng.integers(-3, 12, ANGLES)) % COUNTS_PER_REV
    seen, step_of_first = [], -1
    for clock in range(ANGLES + LATENCY):
        dut.angle.value = dut.position.value = int(angles[min(clock, ANGLES - 1)])
        await RisingEdge(dut.clock)
        if clock == 0:
            step_of_first = int(dut.sweep_step.value)
        seen.append(outputs(dut))
    # cocotb decides which of the two coroutines it resumes first at an edge, so the clock numbers
    # may differ by one.
    first = next(c for c in (near - 1, near, near + 1) if sweep.steps[c] == step_of_first)
    effective = effective_history(sweep, bank)
    accepted = np.arange(0, ANGLES, FOLD)
    built = LANES // FOLD
    blocks = np.arange(LANES) // built
    rows = first + accepted[:, np.newaxis] + blocks + READ_CLOCKS
    amplitudes = effective[rows, np.arange(LANES)]
    phases = phase_unit(angles[accepted], bank.phase_steps, bank.phase_offsets)
    sums = add_pairs(harmonic_unit(phases, amplitudes), 0)
    limit = correction_limit(COUNTS_PER_REV) << PAIR_FRACTION
    model = subtract(
        angles[accepted], angles[accepted], np.clip(sums, -limit, limit), COUNTS_PER_REV
    )
    found = np.array(seen[LATENCY::FOLD][: accepted.size])
    expected = np.column_stack(model)
    apart = np.flatnonzero((found != expected).any(axis=1))
    assert not apart.size, (apart[:5], apart.size, found[apart[:3]], expected[apart[:3]])
    assert np.unique(amplitudes[:, 0]).size > 5


def effective_history(sweep: Sweep, bank: Coefficients) -> np.ndarray[Any, Any]:
    """Return the amplitudes that a read of bank 1 would give in each clock, (clocks, lanes)."""
    clocks = len(sweep.steps) + AMPLITUDE_SWEEP_CLOCKS
    found = np.zeros((clocks, LANES), dtype=np.int64)
    now = np.zeros(LANES, dtype=np.int64)
    held, sweeps = Modulators(), iter(sweep.held)
    writes: dict[int, tuple[int, int]] = {}
    for clock, step in enumerate(sweep.steps):
        lane = step - 64
        if 0 <= lane < LANES:
            number = bank.modulator_numbers[lane]
            word = effective_amplitudes(bank.amplitudes[lane], held.values[number])
            writes[clock + WRITE_CLOCKS] = (lane, int(word))
        if step == AMPLITUDE_SWEEP_CLOCKS - 1:
            held = next(sweeps)
    for clock in range(clocks):
        if clock in writes:
            lane, word = writes[clock]
            now[lane] = word
        found[clock] = now
    return found
