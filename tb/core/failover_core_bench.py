"""Tests the core with FAILOVER in cocotb: heads that fail in each possible way, and their return.

Each test of a failure corresponds to a row of the table in docs/heads.md, which states the check
that detects the fault, the time until it does, and the error of the output until then. The tests
also check that the output never makes a step, and that the mean without the head is right.
"""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles, RisingEdge
from numpy.typing import NDArray

from arctrue.gateware.mean_set import WEIGHT_ONE, MeanSet
from arctrue.gateware.parity_sum import PARITY_LSB_COUNTS, parity_weights
from arctrue.gateware.register_access import RegisterMap
from tb.core.mean_core_bench import (
    CLOCKS_PER_COUNT,
    COUNTS,
    HEADS,
    LANES,
    LARGEST_STEP,
    LATENCY,
    PLACES,
    POSITION_CLOCKS,
    Table,
    check_mean,
    lanes_of,
    mean_bound,
    mean_of,
    prepared,
    turn_rad,
)

STEP_LIMIT = 40
"""Limit, in counts, above which a change between heads is a step; the motion of the axis (MOTION)
changes a difference of two heads by at most 36 counts."""
MISSING = 24
"""Number of counts by which the other heads must move until a head without edges counts as dead; it
is below STEP_LIMIT, so that this check finds a dead head first."""
LOAD_CLOCKS = 4 * (4 * LANES + 10) + 4
"""Largest number of clocks from `load` to the swap, as the header of prepared_sets states."""
DECODER_CLOCKS = 20
"""Total number of clocks from the pins to the fault, from the fault to the load, and from the first
angle of the new set to the interrupt."""
SWAP_WAITS = 12
"""Allowance in clocks for a swap that waits for the idle bank or for a head's zero; no swap waits
in these tests."""
CARRIERS = {0: 1, 1: 2, 2: 1, 3: 1, 4: 1}
LANES_ERROR = 2.0
"""Allowance in counts for the difference between the corrections E of two sets; the amplitudes of
the disc's harmonics add up to 2.1 counts."""
UNTIL_ZEROS = 190 + max(-place if place < 140 else COUNTS - place for place in PLACES)
"""Number of counts from the start at -150 until every head has passed its index; axis and disc
displace an index by up to 11 counts. Tests with three heads wait a whole turn and more, because
their mean of two heads contains the motion of the axis."""
if HEADS < 4:
    UNTIL_ZEROS = COUNTS + 150
RAMP_RATE = 32 << 24
"""32·2⁻¹¹ count per clock: 20 counts take 1,280 clocks."""
RAMP_COUNTS_A_CLOCK = RAMP_RATE * 2.0**-35
EVERYONE = tuple(range(1, HEADS + 1))
TURNS_WITHOUT_A_HEAD = {"missing_edges"} if "QUICK" in os.environ else {"all"}
"""Causes of failure after which the mean of the other heads is compared over a whole turn; "all"
means every cause."""


def set_of(missing: int) -> MeanSet:
    """Return the mean without head ``missing`` (0: of all heads)."""
    heads = tuple(head for head in EVERYONE if head != missing)
    return mean_of(heads, CARRIERS[missing])


async def guarded(dut: Any, **settings: int) -> Table:
    """Return a turning table; all prepared sets are written, set 0 is active, and the checks for
    failures are enabled."""
    machine = await prepared(dut)
    names = machine.registers
    assert await names.read("capability.failover") == 1
    cocotb.start_soon(machine.run())
    await names.update("control", compensate=1, output_enable=1)
    for missing in range(HEADS + 1):
        mean = set_of(missing)
        await names.write_set(missing, lanes_of(mean), mean)
    await machine.turn(UNTIL_ZEROS)
    await names.write("missing_edges", MISSING)
    await names.write("parity.step_limit", STEP_LIMIT)
    await names.write("index_tolerance", 2)
    await take(names, 0)
    await machine.turn(150)
    await names.clear_interrupts()
    await names.update("interrupt_enable", failover=1)
    causes = dict.fromkeys(
        ("illegal", "overspeed", "swallowed", "missing_edges", "step", "index"), 1
    )
    await names.update("failover", **{"enable": 1, **causes, **settings})
    return machine


async def take(names: RegisterMap, number: int) -> None:
    await names.write_raw("heads_command", 1 << 7 | number << 4)
    while await names.read("heads_status.busy"):
        pass
    status = await names.read_fields("heads_status")
    assert (status["set"], status["left_out"]) == (number, 1 << number >> 1)


async def until_changed(machine: Table, most: float) -> int:
    """Wait until a prepared set is active, for at most ``most`` clocks; return the clocks."""
    for clocks in range(round(most) + 1):
        if machine.dut.interrupt.value == 1:
            return clocks
        await RisingEdge(machine.dut.clock)
    raise AssertionError(f"no failover within {most:g} clocks")


async def left_out(
    machine: Table, head: int, cause: str, began: int, most: float, off: float
) -> None:
    """Check that ``head`` is left out for ``cause`` within ``most`` clocks and the output stays
    right.

    ``off`` is the permitted additional error of the output in counts until the head is left out.
    """
    names = machine.registers
    clocks = await until_changed(machine, most)
    status = await names.read_fields("heads_status")
    order = ["illegal", "overspeed", "swallowed", "missing_edges", "step", "index"]
    assert (status["left_out"], status["set"]) == (1 << (head - 1), head)
    assert status["cause"] >> order.index(cause) & 1, f"causes {status['cause']:06b}"
    assert await names.read(f"interrupt_status.head{head}_fault") == 1
    assert machine.dut.status_fault.value == 1
    await machine.turn(150)
    error = machine.error(began, LATENCY + POSITION_CLOCKS)
    error -= round(float(np.median(error)) / COUNTS) * COUNTS
    before = machine.error(began - 3000, LATENCY + POSITION_CLOCKS)[:3000]
    before -= round(float(np.median(before)) / COUNTS) * COUNTS
    worst = np.abs(error - np.median(before)).max()
    machine.dut._log.info(f"{cause}: head {head} after {clocks} clocks, off by {worst:.2f} counts")
    assert worst <= off + LANES_ERROR + 1.5
    assert np.abs(np.diff(machine.corrected[began:])).max() <= LARGEST_STEP
    if not TURNS_WITHOUT_A_HEAD & {cause, "all"}:
        return
    first = len(machine.corrected)
    await machine.turn(COUNTS)
    if HEADS > 3:
        check_mean(machine, first, set_of(head))


async def illegal_step(machine: Table, head: int) -> None:
    """Change A and B of a head in the same clock, by which it loses two counts."""
    before = machine.shown[head - 1]
    while machine.shown[head - 1] == before:
        await RisingEdge(machine.dut.clock)
    machine.slips[head - 1] += 2


def share(head: int) -> float:
    """Return the magnitude of a head's weight in the mean of all heads."""
    return abs(set_of(0).weights[head - 1]) / WEIGHT_ONE


@cocotb.test()
async def an_illegal_step_leaves_a_head_out(dut: Any) -> None:
    """A head whose A and B change in one clock, so that it loses two counts, is left out at
    once."""
    machine = await guarded(dut)
    head = HEADS
    began = len(machine.corrected)
    await illegal_step(machine, head)
    await left_out(
        machine, head, "illegal", began, DECODER_CLOCKS + LOAD_CLOCKS + SWAP_WAITS, 2 * share(head)
    )


@cocotb.test()
async def a_fault_of_all_heads_leaves_one_out(dut: Any) -> None:
    """If A and B of every head change in one clock, head 1 is left out, and the flags of all heads
    raise the alarm; each other head keeps its lost counts."""
    machine = await guarded(dut)
    names = machine.registers
    machine.moves = False
    await ClockCycles(dut.clock, 60)
    began = len(machine.corrected)
    machine.slips = [2] * HEADS
    # The table at rest drives the pins only when a slip changes them.
    await until_changed(machine, DECODER_CLOCKS + LOAD_CLOCKS + SWAP_WAITS)
    status = await names.read_fields("heads_status")
    assert (status["left_out"], status["set"], status["cause"]) == (1, 1, 1)
    faults = await names.read_fields("interrupt_status")
    assert all(faults[f"head{head}_fault"] for head in EVERYONE)
    assert dut.status_fault.value == 1
    machine.moves = True
    await machine.turn(150)
    assert await names.read("heads_status.left_out") == 1
    assert np.abs(np.diff(machine.corrected[began:])).max() <= LARGEST_STEP


@cocotb.test()
async def a_dead_carrier_is_left_out(dut: Any) -> None:
    """A dead head is found when all other heads have moved by `missing_edges` counts, but not at
    standstill."""
    machine = await guarded(dut)
    machine.moves = False
    await ClockCycles(dut.clock, 50)
    machine.stands = {1}
    await ClockCycles(dut.clock, 600)
    assert dut.interrupt.value == 0, "a dead head was found at standstill"
    machine.moves = True
    began = len(machine.corrected)
    # Because of the motion of the axis, 18 counts to each side, one of the other heads may reach
    # the limit later.
    counts = MISSING + 18
    most = counts * CLOCKS_PER_COUNT + DECODER_CLOCKS + LOAD_CLOCKS + SWAP_WAITS
    off = share(1) * (counts + (LOAD_CLOCKS + DECODER_CLOCKS) / CLOCKS_PER_COUNT)
    await left_out(machine, 1, "missing_edges", began, most, off)


@cocotb.test()
async def a_head_that_is_too_fast_is_left_out(dut: Any) -> None:
    """A head is left out at the first two edges that are closer to each other than
    `minimum_edge_spacing`."""
    machine = await guarded(dut)
    await machine.registers.write("minimum_edge_spacing", 4)
    head = 2
    began = len(machine.corrected)
    machine.bursts[head - 1] = 4000
    most = 6 + DECODER_CLOCKS + LOAD_CLOCKS + SWAP_WAITS
    await left_out(machine, head, "overspeed", began, most, share(head) * most / 2)


@cocotb.test()
async def a_head_whose_counts_the_filter_suppresses_is_left_out(dut: Any) -> None:
    """A head is left out when the glitch filter suppresses its counts: its signals are faster than
    the filter permits, while the other heads pass the filter.

    The head counts every two clocks, so that A and B change every four clocks; the filter needs six
    equal samples. The decoder reports the fault after four suppressed counts.
    """
    machine = await guarded(dut, illegal=0, overspeed=0)
    await machine.registers.write("filter_length", 6)
    await machine.turn(60)
    head = 2
    began = len(machine.corrected)
    machine.bursts[head - 1] = 400
    most = 6 * 8 + DECODER_CLOCKS + LOAD_CLOCKS + SWAP_WAITS
    await left_out(machine, head, "swallowed", began, most, share(head) * most / 2)


@cocotb.test()
@cocotb.parametrize(acceleration=[0, 0xFFFF_FFFF])
async def a_failover_obeys_the_limits_of_the_ramp(dut: Any, acceleration: int) -> None:
    """The failover removes the error that the slip of the failed head has added to the output (more
    than 10 counts), no faster than the velocity and the acceleration of the ramp permit.

    With acceleration 0 the velocity is `ramp_rate` at once. Otherwise the velocity changes every
    256 clocks, and ½·a·(t + 256)² limits the change after t clocks; with the largest acceleration
    this limit is below 0.02 counts in this test.
    """
    machine = await guarded(dut)
    await machine.registers.write("ramp_rate", RAMP_RATE)
    await machine.registers.write("ramp_acceleration", acceleration)
    head = 3
    slip = 2 * STEP_LIMIT
    right = float(np.median(machine.error(len(machine.corrected) - 500, LATENCY + POSITION_CLOCKS)))
    machine.bursts[head - 1] = -slip
    await until_changed(machine, 2 * slip + DECODER_CLOCKS + 20 + LOAD_CLOCKS + SWAP_WAITS)
    error = await obeys_the_ramp(machine, share(head) * slip, acceleration, set_of(head))
    off, left = abs(error[0] - right), abs(float(np.median(error[-200:])) - right)
    dut._log.info(f"off by {off:.1f}, then {left:.1f} counts")
    assert off > 10.0
    if not acceleration:
        assert left <= 2.0 * mean_bound(set_of(head))


async def obeys_the_ramp(
    machine: Table, counts: float, acceleration: int, mean: MeanSet
) -> NDArray[np.float64]:
    """Check that the output moves by ``counts`` to ``mean`` no faster than velocity and
    acceleration of the ramp permit; return the errors of the output.

    The bound is twice that of check_mean(), for the roundings at the first and at each further
    clock.
    """
    began = len(machine.corrected)
    await ClockCycles(machine.dut.clock, round(counts / RAMP_COUNTS_A_CLOCK) + 300)
    error = machine.error(began, LATENCY + POSITION_CLOCKS)
    after = np.arange(error.size)
    most = after * RAMP_COUNTS_A_CLOCK
    if acceleration:
        most = np.minimum(most, 0.5 * acceleration * 2.0**-59 * (after + 256.0) ** 2)
    moved = np.abs(error - error[0])
    machine.dut._log.info(f"{np.max(moved - most):.2f} counts beyond the ramp")
    assert np.all(moved <= most + 2.0 * mean_bound(mean))
    return error


@cocotb.test()
@cocotb.parametrize(acceleration=[0, 0xFFFF_FFFF])
async def a_return_obeys_the_limits_of_the_ramp(dut: Any, acceleration: int) -> None:
    """The return of a head moves the output no faster than the ramp permits.

    The offset of the head in the set of all heads is 60 counts too large, so that the output moves
    by 60 counts times the head's weight at the return.
    """
    machine = await guarded(dut)
    names = machine.registers
    await names.write("ramp_rate", RAMP_RATE)
    await names.write("ramp_acceleration", acceleration)
    head, wrong = 3, 60
    offsets = list(set_of(0).offsets)
    offsets[head - 1] += 16 * wrong
    mean = replace(set_of(0), offsets=tuple(offsets))
    await names.write_set(0, lanes_of(mean), mean)
    await illegal_step(machine, head)
    await until_changed(machine, DECODER_CLOCKS + LOAD_CLOCKS + SWAP_WAITS)
    await names.clear_interrupts()
    await names.write_raw("heads_command", 1 << (8 + head - 1))
    await until_changed(machine, (COUNTS + 60) * CLOCKS_PER_COUNT + LOAD_CLOCKS)
    assert await names.read("heads_status.set") == 0
    error = await obeys_the_ramp(machine, share(head) * wrong, acceleration, mean)
    # The mean of two of three heads contains the motion of the axis.
    if HEADS > 3 and not acceleration:
        moved = abs(float(np.median(error[-200:])) - error[0])
        assert abs(moved - share(head) * wrong) <= 2.0 * mean_bound(mean)


@cocotb.test()
async def a_head_that_steps_against_the_others_is_left_out(dut: Any) -> None:
    """A slip by twice the step limit, one count every two clocks, is found in spite of the motion
    of the axis."""
    machine = await guarded(dut)
    head = 3
    slip = 2 * STEP_LIMIT
    began = len(machine.corrected)
    machine.bursts[head - 1] = -slip
    most = 2 * slip + DECODER_CLOCKS + 20 + LOAD_CLOCKS + SWAP_WAITS
    await left_out(machine, head, "step", began, most, share(head) * slip)


@cocotb.test()
@cocotb.parametrize(slip=[4, 12])
async def a_small_slip_is_found_at_the_index(dut: Any, slip: int) -> None:
    """A slip below the step limit changes the output by the slip times the head's weight, until the
    head's next index shows the fault."""
    machine = await guarded(dut)
    head = 2
    began = len(machine.corrected)
    machine.bursts[head - 1] = slip
    most = (COUNTS + 30) * CLOCKS_PER_COUNT + DECODER_CLOCKS + LOAD_CLOCKS + SWAP_WAITS
    await left_out(machine, head, "index", began, most, share(head) * slip)


@cocotb.test(skip=HEADS < 4)
async def the_parity_shows_a_slip_at_once(dut: Any) -> None:
    """A slip of 12 counts changes the parity by 12 times the head's parity weight; a parity beyond
    its limit raises the alarm."""
    machine = await guarded(dut, index=0)
    names = machine.registers
    weights = parity_weights(turn_rad(PLACES))
    await names.write_parity_weights(weights.tolist())
    head = 3

    machine.moves = False
    await ClockCycles(dut.clock, 30)
    await names.snapshot()
    before = await names.read("parity.value")
    limit = int(abs(before) * PARITY_LSB_COUNTS) + 4
    await names.write("parity.limit", limit)
    await names.command("clear_output")
    await names.update("alarm", sources=0x08)
    await ClockCycles(dut.clock, 20)
    assert (await names.read("heads_status.parity_beyond"), int(dut.alarm.value)) == (0, 0)
    # Choose the direction of the slip so that the magnitude of the parity grows.
    slip = 12 if before * int(weights[head - 1]) >= 0 else -12
    machine.bursts[head - 1] = slip
    await ClockCycles(dut.clock, 100)
    await names.snapshot()
    changed = await names.read("parity.value") - before
    expected = slip * int(weights[head - 1]) * 2.0 ** (11 - 16)
    assert abs(changed - expected) <= 1, "more than the roundings before and after"
    assert (await names.read("heads_status.parity_beyond"), int(dut.alarm.value)) == (1, 1)
    assert dut.interrupt.value == 0, "a head was left out"


@cocotb.test()
async def a_head_comes_back_after_its_index(dut: Any) -> None:
    """A head returns after a request and its next index; after that the mean of all heads is right
    again."""
    machine = await guarded(dut)
    names = machine.registers
    head = 2
    await illegal_step(machine, head)
    await until_changed(machine, DECODER_CLOCKS + LOAD_CLOCKS + SWAP_WAITS)
    await names.clear_interrupts()
    await names.write_raw("heads_command", 1 << (8 + head - 1))
    assert await names.read("heads_status.index_seen") == (1 << HEADS) - 1 - (1 << (head - 1))
    assert await names.read("heads_status.set") == head
    began = len(machine.corrected)
    await until_changed(machine, (COUNTS + 60) * CLOCKS_PER_COUNT + LOAD_CLOCKS)
    status = await names.read_fields("heads_status")
    assert (status["set"], status["left_out"]) == (0, 0)
    await machine.turn(150)
    assert np.abs(np.diff(machine.corrected[began:])).max() <= LARGEST_STEP
    first = len(machine.corrected)
    await machine.turn(COUNTS)
    if HEADS > 3:
        check_mean(machine, first, set_of(0))


@cocotb.test()
async def no_head_fails_without_a_fault(dut: Any) -> None:
    """No head is left out while the axis moves and a head slips by 2 counts, the index tolerance.

    A fault of a kind that is not enabled has no effect either.
    """
    machine = await guarded(dut, illegal=0)
    machine.bursts[1] = 2
    await machine.turn(2 * COUNTS)
    await illegal_step(machine, HEADS)
    await machine.turn(60)
    assert dut.interrupt.value == 0
    assert await machine.registers.read("heads_status.left_out") == 0


@cocotb.test()
async def a_swap_does_not_bring_a_dead_head_back(dut: Any) -> None:
    """The core refuses the processor's words and a prepared set if they use a dead head.

    It accepts words without this head; the head stays left out. After the head's index and a
    request for its return, the core accepts words that use all heads again.
    """
    machine = await guarded(dut)
    names = machine.registers
    head = 2
    machine.stands = {head}
    most = (MISSING + 18) * CLOCKS_PER_COUNT + DECODER_CLOCKS + LOAD_CLOCKS + SWAP_WAITS
    await until_changed(machine, most)
    await machine.turn(150)
    everyone, others = set_of(0), set_of(head)

    async def swapped(mean: MeanSet) -> dict[str, int]:
        before = await names.read("swap_count")
        await names.write_coefficients(lanes_of(mean))
        await names.write_mean(mean)
        await names.command("swap")
        await machine.turn(150)
        status = await names.read_fields("heads_status")
        return {**status, "swaps": await names.read("swap_count") - before}

    def right(status: dict[str, int], **expected: int) -> None:
        assert {name: status[name] for name in expected} == expected

    began = len(machine.corrected)
    right(await swapped(everyone), swaps=0, left_out=1 << head - 1, set=head, swap_refused=1)
    await names.command("clear_output")
    assert await names.read("heads_status.swap_refused") == 0
    await names.write_raw("heads_command", 1 << 7)
    await machine.turn(30)
    right(
        await names.read_fields("heads_status"),
        **{"left_out": 1 << head - 1, "set": head, "busy": 0, "swap_refused": 1},
    )
    await names.command("clear_output")
    first = len(machine.corrected)
    await machine.turn(COUNTS)
    if HEADS > 3:
        check_mean(machine, first, others)
    right(await swapped(others), swaps=1, left_out=1 << head - 1, set=7, swap_refused=0)
    right(await swapped(everyone), swaps=0, left_out=1 << head - 1, set=7, swap_refused=1)

    machine.stands = set()
    # The head's pins jump to the table's angle. This may be an illegal transition, which has no
    # effect for a left-out head.
    await machine.turn(COUNTS + 60)
    right(await names.read_fields("heads_status"), left_out=1 << head - 1, set=7)
    await names.write_raw("heads_command", 1 << (8 + head - 1))
    await machine.turn(COUNTS + 60)
    right(await names.read_fields("heads_status"), left_out=0, set=7)
    right(await swapped(everyone), swaps=1, left_out=0, set=7)
    assert np.abs(np.diff(machine.corrected[began:])).max() <= LARGEST_STEP
    first = len(machine.corrected)
    await machine.turn(COUNTS)
    if HEADS > 3:
        check_mean(machine, first, everyone)


@cocotb.test()
async def a_set_that_uses_the_failed_head_is_not_taken(dut: Any) -> None:
    """If the set for a failed head uses this head, the active words stay active, and a flag reports
    the refusal."""
    machine = await guarded(dut)
    names = machine.registers
    head = 3
    await names.write_set(head, lanes_of(set_of(0)), set_of(0))
    await illegal_step(machine, head)
    await machine.turn(150)
    status = await names.read_fields("heads_status")
    assert (status["left_out"], status["set"], status["swap_refused"]) == (0, 0, 1)
    assert await names.read(f"interrupt_status.head{head}_fault") == 1
    assert dut.interrupt.value == 0
