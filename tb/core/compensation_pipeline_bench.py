"""Compares compensation_pipeline with its model and with equation (9) in cocotb tests."""

from __future__ import annotations

import os
import random
from itertools import combinations
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from numpy.typing import NDArray
from sim.tests.gateware.equation_9 import correction_bound_counts, error_of_words_counts

from arctrue.gateware.coefficient_memory import CoefficientMemory, bank_words
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.compensation_pipeline import compensate, compensate_clocks
from arctrue.gateware.correction_ramp import HOLD
from arctrue.gateware.error_compensation import correction_limit
from arctrue.gateware.harmonic_lane import Rotation
from arctrue.gateware.table_rotation import error_bound
from arctrue.generated.number_formats import (
    CORRECTION_FRACTION,
    DELAY_LINE_LATENCY,
    HARMONIC_LATENCY,
    PHASE_LATENCY,
    PIPELINE_LATENCY,
)

LANES = int(os.environ.get("LANES", "4"))
ANGLES = int(os.environ.get("ANGLES", "500"))
FOLD = int(os.environ.get("FOLD", "1"))
LATENCY = PIPELINE_LATENCY + FOLD - 1
COSINE_WIDTH = int(os.environ.get("COSINE_WIDTH", "18"))
ROTATION: Rotation = "table" if os.environ.get("ROTATION") == "table" else "cordic"
# SUM_COUNTS: sum of the amplitudes in counts; the default is 250 arcsec, as for the paper's table.
ARCSEC_250 = 250 / 1_296_000
SUM_COUNTS = float(os.environ.get("SUM_COUNTS", "0"))
COUNTS_PER_REV = int(os.environ.get("COUNTS_PER_REV", str(2**24)))
RATE_ONE = 1 << 24
RATE_MAX = 2**32 - 1
# RAMP_UNITS: change of the ramp per clock at RATE_MAX, in whole units of 2⁻¹¹ count.
RAMP_UNITS = 255
UNIT = 2**CORRECTION_FRACTION


async def start(dut: Any, ramp_rate: int = RATE_MAX) -> None:
    for name in (
        "angle",
        "position",
        "apply",
        "zero_moved",
        "put_back",
        "referenced",
        "write_enable",
        "write_offset",
        "write_address",
        "write_data",
        "read_address",
        "swap",
    ):
        getattr(dut, name).value = 0
    dut.counts_per_rev.value = COUNTS_PER_REV
    dut.ramp_rate.value = ramp_rate
    dut.ramp_acceleration.value = 0
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(PIPELINE_LATENCY):
        await RisingEdge(dut.clock)
    dut.reset.value = 0


async def align(dut: Any) -> None:
    """Wait until the pipeline accepts an angle in the next clock."""
    while True:
        await RisingEdge(dut.clock)
        if dut.accept.value == 1:
            break
    for _ in range(FOLD - 1):
        await RisingEdge(dut.clock)
        assert dut.accept.value == 0


async def write(dut: Any, address: int | None, data: int) -> None:
    dut.write_enable.value = int(address is not None)
    dut.write_offset.value = int(address is None)
    dut.write_address.value = address or 0
    dut.write_data.value = data
    await RisingEdge(dut.clock)
    dut.write_enable.value = 0
    dut.write_offset.value = 0
    await RisingEdge(dut.clock)
    while dut.write_acknowledge.value != 1:
        await RisingEdge(dut.clock)


async def load(dut: Any, bank: Coefficients) -> None:
    """Write ``bank`` into the idle bank and swap; return when the idle bank is filled again."""
    for address, data in bank_words(bank):
        await write(dut, address, data)
    await write(dut, None, bank.offset % 2**32)
    dut.swap.value = 1
    await RisingEdge(dut.clock)
    dut.swap.value = 0
    for _ in range(LATENCY + FOLD + 4 * LANES + 6):
        await RisingEdge(dut.clock)
    assert dut.swap_busy.value == 0


def outputs(dut: Any) -> tuple[int, int, int]:
    return (
        dut.corrected_angle.value.to_unsigned(),
        dut.corrected_position.value.to_signed(),
        dut.correction.value.to_signed(),
    )


def random_bank(rng: np.random.Generator, sum_counts: float) -> Coefficients:
    """Return a bank with a random order up to 65535 in the last lane, order 1 in lane 0, order
    16,384 in lane 1 if there are more than two lanes, and random orders below 120 in the others.

    The magnitudes of the amplitudes add up to ``sum_counts``, unless one of them is limited to
    8,191 counts.
    """
    orders = rng.integers(1, 120, LANES)
    orders[0] = 1
    orders[-1] = rng.integers(0, 65536)
    if LANES > 2:
        orders[1] = 16_384
    weights = rng.random(LANES) * rng.choice([-1, 1], LANES)
    amplitudes = np.clip(sum_counts * weights / np.abs(weights).sum(), -8191, 8191)
    return Coefficients.from_harmonics(
        orders,
        amplitudes,
        rng.uniform(-np.pi, np.pi, LANES),
        COUNTS_PER_REV,
        LANES,
        float(rng.uniform(-0.1, 0.1) * min(sum_counts, 8191)),
    )


async def settle(dut: Any) -> None:
    """Switch the correction on with amplitudes of zero, so that the ramp has nothing to remove."""
    await load(dut, Coefficients.zero(COUNTS_PER_REV, LANES))
    dut.apply.value = 1
    for _ in range(LATENCY + FOLD + 2):
        await RisingEdge(dut.clock)


@cocotb.test()
async def a_turn_of_angles(dut: Any) -> None:
    """The outputs for angles evenly spread over a turn equal the model's and are near equation (9).

    In a folded pipeline, angles that are not accepted come between the accepted ones.
    """
    rng = np.random.default_rng(LANES)
    sum_counts = SUM_COUNTS or ARCSEC_250 * COUNTS_PER_REV
    bank = random_bank(rng, sum_counts)
    turn = np.arange(ANGLES, dtype=np.int64) * COUNTS_PER_REV // ANGLES
    turn[-3:] = COUNTS_PER_REV - 1, 0, COUNTS_PER_REV - 1
    position = (
        turn + rng.integers(-(2**31) // COUNTS_PER_REV, 2**31 // COUNTS_PER_REV) * COUNTS_PER_REV
    )
    position = (position + 2**31) % 2**32 - 2**31

    # Swap where the new correction is about 0, so that the ramp is short.
    tried = rng.integers(0, COUNTS_PER_REV, 20_000)
    corrections = compensate(tried, tried, bank, COSINE_WIDTH, ROTATION).correction
    nearest = int(np.argmin(np.abs(corrections)))
    await start(dut)
    dut.apply.value = 1
    dut.angle.value = int(tried[nearest])
    await load(dut, bank)
    for _ in range(abs(int(corrections[nearest])) // RAMP_UNITS + LATENCY + FOLD):
        await RisingEdge(dut.clock)
    assert dut.ramp_busy.value == 0

    await align(dut)
    seen = []
    for clock in range(FOLD * ANGLES + LATENCY):
        now = min(clock // FOLD, ANGLES - 1)
        is_accepted = clock % FOLD == 0
        dut.angle.value = int(turn[now] if is_accepted else rng.integers(0, COUNTS_PER_REV))
        dut.position.value = int(position[now] if is_accepted else rng.integers(-(2**31), 2**31))
        await RisingEdge(dut.clock)
        assert int(dut.accept.value) == is_accepted
        seen.append(outputs(dut))
    every_clock = np.array(seen[LATENCY:], dtype=np.int64)
    found = every_clock[::FOLD]
    assert np.array_equal(every_clock, np.repeat(found, FOLD, axis=0)), (
        "an output changes between two accepted angles"
    )
    if file := os.environ.get("FOUND_FILE"):
        np.save(file, found)

    model = compensate(turn, position, bank, COSINE_WIDTH, ROTATION)
    for name, column, expected in zip(model._fields, found.T, model, strict=True):
        different = np.flatnonzero(column != expected)
        assert not different.size, (
            f"{name} at angle {turn[different[0]]}: {column[different[0]]}, "
            f"expected {expected[different[0]]} ({different.size} of {ANGLES} differ)"
        )
    assert found[:, 0].min() >= 0
    assert found[:, 0].max() < COUNTS_PER_REV
    exact = bank.error_counts(turn)
    error = np.abs(position - found[:, 1] - exact)
    error = np.minimum(error, 2.0**32 - error)
    bound = correction_bound_counts(bank, COSINE_WIDTH)
    if ROTATION == "table":
        # The bound is half a count for the single rounding, plus the error of the cosine table
        # times the sum of the amplitudes.
        bound = 0.5 + float(np.abs(bank.amplitudes_counts).sum()) * error_bound()
    dut._log.info(
        f"largest deviation from equation (9): {error.max():.3f}, bound {bound:.3f} counts"
    )
    assert np.abs(exact).max() < correction_limit(COUNTS_PER_REV)
    assert error.max() <= bound
    if sum_counts <= ARCSEC_250 * COUNTS_PER_REV and COSINE_WIDTH == 18:
        assert error.max() <= 1.0
    if SUM_COUNTS:
        assert found[:, 2].max() - found[:, 2].min() > sum_counts * UNIT / 4


@cocotb.test()
async def latencies_of_table_1(dut: Any) -> None:
    """The phase takes 5 clocks, the harmonics 20, the compensation 4, in total 29; the delay line
    25.

    In a folded pipeline the reading waits FOLD - 1 more clocks for the last pair sums.
    """
    await start(dut)
    await load(dut, Coefficients.from_harmonics([1], [10.0], [0.0], COUNTS_PER_REV, LANES))
    dut.apply.value = 1
    for _ in range(500):
        await RisingEdge(dut.clock)
    assert dut.ramp_busy.value == 0
    watched = {
        "delayed_reading": dut.delayed_reading,
        "corrected_position": dut.corrected_position,
        "corrected_angle": dut.corrected_angle,
        "corrected_referenced": dut.corrected_referenced,
        "correction": dut.correction,
    }
    if FOLD == 1:  # folded: the phases change with the lanes
        watched |= {"phases": dut.phases, "pair_sums": dut.pair_sums}
    await align(dut)
    before = {name: signal.value for name, signal in watched.items()}
    dut.angle.value = COUNTS_PER_REV // 3
    dut.position.value = COUNTS_PER_REV // 3
    dut.referenced.value = 1
    changed: dict[str, int] = {}
    for clock in range(2 * LATENCY):
        await RisingEdge(dut.clock)
        for name, signal in watched.items():
            if name not in changed and signal.value != before[name]:
                changed[name] = clock
    dut._log.info(f"latencies in clocks: {changed}")
    expected = {
        "delayed_reading": 25 + FOLD - 1,
        "corrected_position": 29 + FOLD - 1,
        "corrected_angle": 29 + FOLD - 1,
        "corrected_referenced": 29 + FOLD - 1,
        "correction": 29 + FOLD - 1,
    }
    if FOLD == 1:
        expected |= {"phases": 5, "pair_sums": 5 + 20}
    assert changed == expected
    assert (PHASE_LATENCY, HARMONIC_LATENCY, DELAY_LINE_LATENCY) == (5, 20, 25)


def banks_of_angles(
    markers: list[bool],
    swaps: list[tuple[bool, bool]],
    acknowledged: list[tuple[int | None, int] | None],
) -> tuple[list[Coefficients], list[int]]:
    """Return the banks in use one after the other, and for each angle the number of its bank.

    For each clock, ``markers`` states whether the angle is the first of a new bank, ``swaps``
    whether a swap is requested and whether a write is pending, and ``acknowledged`` which write
    ends. The function also checks that each requested swap takes place once and in time: with the
    next accepted angle, unless a write or a previous swap delays it.
    """
    memory = CoefficientMemory(COUNTS_PER_REV, LANES)
    banks, bank = [memory.active], []
    filled = LATENCY + 4 * LANES + 6  # clocks from a marker to a filled idle bank
    asked, last, in_the_way = -1, -filled, False
    for clock, marker in enumerate(markers):
        if marker:
            assert asked >= 0
            assert clock % FOLD == 0
            if not in_the_way:
                assert clock - asked <= FOLD
            assert clock - max(asked, last + filled) <= FOLD + 2
            memory.swap()
            banks.append(memory.active)
            asked, last = -1, clock
        bank.append(len(banks) - 1)
        swap, write_pending = swaps[clock]
        if swap and asked < 0:
            asked, in_the_way = clock, write_pending or clock < last + filled
        elif asked >= 0:
            in_the_way |= write_pending
        write = acknowledged[clock]
        if write is not None and write[0] is None:
            memory.write_offset(write[1])
        elif write is not None:
            memory.write(write[0], write[1])
    assert asked < 0 or len(markers) - max(asked, last + filled) <= FOLD + 2
    return banks, bank


@cocotb.test()
async def swap_and_bypass_under_load(dut: Any) -> None:
    """Each angle is corrected with one bank, and the correction makes no step, while the angle
    changes in every clock and writes, swaps and changes of `apply` come at random instants."""
    rng = np.random.default_rng(7)
    choose = random.Random(7)
    largest = min(COUNTS_PER_REV / 8, 2000.0)
    ramp_rate = 177 * RATE_ONE + 12345
    await start(dut, ramp_rate)
    await settle(dut)
    queue: list[tuple[int | None, int]] = []
    pending: tuple[int | None, int] | None = None
    applied, swaps, acknowledged = [], [], []
    apply = True
    speed = max(1, COUNTS_PER_REV // 1777)
    position = rng.integers(-(2**30), 2**30) + np.cumsum(rng.integers(0, 2 * speed, ANGLES))
    held = np.arange(ANGLES) // FOLD * FOLD
    angle = position % COUNTS_PER_REV
    seen: list[tuple[int, int, int]] = []
    done = []
    await align(dut)
    for clock in range(ANGLES + LATENCY):
        now = min(clock, ANGLES - 1)
        swapping = False
        if clock < ANGLES:
            if choose.random() < 0.004:
                apply = not apply
            applied.append(apply)
            swapping = choose.random() < 0.02
            if not queue and choose.random() < 0.05:
                new = random_bank(rng, float(rng.uniform(0.0, largest)))
                queue = [*bank_words(new), (None, new.offset % 2**32)]
                if choose.random() < 0.5:
                    queue = queue[: choose.randrange(1, 5)]
        starts = pending is None and bool(queue) and clock < ANGLES
        if starts:
            pending = queue.pop(0)
        address, data = pending or (0, 0)
        dut.write_enable.value = int(starts and address is not None)
        dut.write_offset.value = int(starts and address is None)
        dut.write_address.value = address or 0
        dut.write_data.value = data
        dut.swap.value = int(swapping)
        dut.apply.value = int(applied[now])
        dut.angle.value = int(angle[now])
        dut.position.value = int(position[now])
        swaps.append((swapping, pending is not None))
        await RisingEdge(dut.clock)
        seen.append(outputs(dut))
        done.append(int(dut.swap_done.value))
        # The word is in the idle bank in the clock of its acknowledge.
        acknowledged.append(pending if dut.write_acknowledge.value == 1 else None)
        if dut.write_acknowledge.value == 1:
            assert pending is not None
            pending = None
    markers = [bool(marker) for marker in done[LATENCY:]]
    banks, bank = banks_of_angles(markers, swaps, acknowledged)
    found = np.array(seen[LATENCY:], dtype=np.int64)
    assert len(banks) > ANGLES // 200
    check_continuity(
        found[:, 2],
        banks,
        np.array(bank),
        angle[held],
        np.array(markers),
        np.array(applied)[held],
        ramp_rate,
    )
    model = compensate_clocks(
        angle, position, banks, bank, markers, applied, ramp_rate, fold=FOLD, rotation=ROTATION
    )
    # The model starts after a reset, and `apply` rises in its first clock; in the pipeline `apply`
    # was high before. Both give the same correction, because the amplitudes are zero at that time.
    for name, column, expected in zip(
        ("angle", "position", "correction"), found.T, model[:3], strict=True
    ):
        different = np.flatnonzero(column != expected)
        assert not different.size, f"{name} differs first in clock {different[0]}"


def check_continuity(
    correction: NDArray[np.int64],
    banks: list[Coefficients],
    bank: NDArray[np.int64],
    angle: NDArray[np.int64],
    markers: NDArray[np.bool_],
    applied: NDArray[np.bool_],
    ramp_rate: int,
) -> None:
    """Check that the correction changes per clock by at most the rate of the ramp, plus |Δε|, the
    change of ε of the active bank, plus the rounding errors.

    In the clock in which the hold after a marker ends, Δε is the change over two clocks.
    """
    ideal = np.empty((2, angle.size))
    bounds = np.empty(angle.size)
    for index, entry in enumerate(banks):
        met = np.flatnonzero(bank == index)
        if met.size:
            # Compute ε at this angle and at the angle before with the same bank, so that Δε
            # contains no change of the bank.
            ideal[0, met] = error_of_words_counts(entry, angle[met])
            ideal[1, met] = error_of_words_counts(entry, angle[met - 1])
            bounds[met] = correction_bound_counts(entry) - 0.5
    ideal[:, ~applied] = 0.0
    bounds[~applied] = 0.0
    stepped = markers.copy()
    stepped[1:] |= applied[1:] != applied[:-1]
    change = np.diff(correction) / UNIT
    assert np.all(change[stepped[1:]] == 0), (
        "the correction changed in the clock of a marker or of a change of apply"
    )
    rate = -(-ramp_rate // RATE_ONE) / UNIT
    moved = np.abs(ideal[0] - ideal[1])
    # A marker, or a change of `apply`, holds the correction for three clocks. In the next clock the
    # correction changes by the change of ε over two clocks, because the ramp stores its difference
    # from ε one clock after the marker.
    after_hold = np.flatnonzero(stepped[:-HOLD]) + HOLD
    moved[after_hold] += moved[after_hold - 1]
    allowed = moved[1:] + rate + 2 * bounds[1:] + 1 / UNIT
    assert np.all(np.abs(change) <= allowed), f"step in clock {np.argmax(np.abs(change) - allowed)}"
    # Check that the correction changes, because otherwise the test above would prove nothing.
    assert np.abs(change).max() > rate


@cocotb.test()
async def zeros_move_between_two_angles(dut: Any) -> None:
    """The corrected position makes no step if zeros move twice between two accepted angles, whether
    the two moves are of one head or of two heads.

    The moves come in every pair of clocks from one accepted angle to the next. Both put counts
    back, and the angle from the new zero has another correction. The ramp moves the output by less
    than a count per clock, so that the rounded output steps by at most one count. At the end, the
    corrected position contains all counts that were put back.
    """
    largest = 20.0
    await start(dut)
    await load(dut, Coefficients.from_harmonics([1], [largest], [0.0], COUNTS_PER_REV, LANES))
    dut.apply.value = 1
    settled = round(4 * largest * UNIT) // RAMP_UNITS + LATENCY + FOLD
    for _ in range(settled):
        await RisingEdge(dut.clock)
    assert dut.ramp_busy.value == 0

    await align(dut)
    position = moved = angle = 0
    way = 1
    corrected = []
    for first, second in combinations(range(FOLD + 1), 2):
        for clock in range(64):
            if clock in (first, second):
                moved, position = 1 - moved, position + way * (11 if clock == first else 9)
            if clock == second:
                angle = COUNTS_PER_REV // 2 - angle
            dut.zero_moved.value = moved
            dut.put_back.value = position % 2**16
            dut.position.value = position
            dut.angle.value = angle
            await RisingEdge(dut.clock)
            corrected.append(dut.corrected_position.value.to_signed())
        way = -way
    for _ in range(settled):
        await RisingEdge(dut.clock)
        corrected.append(dut.corrected_position.value.to_signed())
    steps = np.abs(np.diff(corrected))
    assert steps.any()
    assert steps.max() <= 1, f"the output stepped by {steps.max()} counts"
    assert dut.ramp_busy.value == 0
    exact = largest * np.cos(2.0 * np.pi * angle / COUNTS_PER_REV)
    assert abs(corrected[-1] - (position - exact)) <= 1.0


@cocotb.test()
async def reset_under_load(dut: Any) -> None:
    """A reset of one clock removes the correction at once, and the ramp restores it."""
    await start(dut)
    await load(dut, Coefficients.from_harmonics([0], [20.0], [0.0], COUNTS_PER_REV, LANES))
    dut.apply.value = 1
    for _ in range(1000):
        await RisingEdge(dut.clock)
    assert dut.corrected_position.value.to_signed() == -20
    dut.reset.value = 1
    await RisingEdge(dut.clock)
    dut.reset.value = 0
    corrections = []
    for _ in range(1000):
        await RisingEdge(dut.clock)
        corrections.append(dut.correction.value.to_signed())
    # From two clocks after the reset on, no correction from before the reset is left in the
    # pipeline.
    rising = np.array(corrections[1:])
    assert rising[0] == 0
    assert np.all(np.diff(rising) >= 0)
    assert np.diff(rising).max() <= 256
    assert dut.corrected_position.value.to_signed() == -20
