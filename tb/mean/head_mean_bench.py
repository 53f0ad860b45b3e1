"""Tests in cocotb that the output `position` of head_mean continues without a gap when another head
becomes the carrier (the head whose counts the output follows)."""

from __future__ import annotations

import os
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from numpy.typing import NDArray

from arctrue.gateware.mean_set import WEIGHT_ONE, MeanSet
from arctrue.gateware.weighted_mean import weighted_mean, whole_readings
from arctrue.generated.number_formats import (
    ANGLE_WIDTH,
    MEAN_LATENCY,
    POSITION_WIDTH,
)
from tb.support.flat import flat

HEADS = int(os.environ.get("HEADS", "2"))
CHOICE_CLOCKS = int(HEADS > 2)
COUNTS = 5003
CLOCKS = 4000


@dataclass
class Seen:
    """Outputs of the entity in one clock."""

    angle: int
    position: int
    phase: int
    apply: int
    referenced: int
    carrier: int
    term: int
    jumped: int
    jump: int


def outputs(dut: Any) -> Seen:
    return Seen(
        dut.angle.value.to_unsigned(),
        dut.position.value.to_signed(),
        dut.phase_of_zero.value.to_unsigned(),
        int(dut.apply.value),
        int(dut.referenced.value),
        dut.carrier.value.to_unsigned(),
        dut.mean_term.value.to_signed(),
        int(dut.jumped.value),
        dut.jump.value.to_signed(),
    )


def motion(rng: np.random.Generator) -> NDArray[np.int64]:
    """Return positions (clocks, heads) in counts: the table moves to and fro over about a quarter
    of a turn, by at most one count per clock.

    The difference between two heads varies with the angle by up to ±80 counts; each head counts
    from its own zero.
    """
    steps = np.cumsum(np.where(np.sin(np.arange(CLOCKS) / 320.0) > -0.3, 0.9, -0.9))
    places = rng.uniform(0.0, 2.0 * np.pi, HEADS)
    own = 40.0 * np.sin(2.0 * np.pi * steps[:, np.newaxis] / COUNTS + places)
    return np.rint(steps[:, np.newaxis] + own).astype(np.int64) + rng.integers(
        -(2**20), 2**20, HEADS
    )


async def start(dut: Any) -> None:
    for name in (
        *("angles", "positions", "phases_of_zero", "put_backs", "zeros_moved", "indices_seen"),
        *("unsettle", "write_enable", "hold_writes", "swap_comes", "read_address", "compensate"),
    ):
        getattr(dut, name).value = 0
    dut.counts_per_rev.value = COUNTS
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(4):
        await RisingEdge(dut.clock)
    dut.reset.value = 0


def random_set(rng: np.random.Generator, zeros: NDArray[np.int64]) -> MeanSet:
    """Return a mean with random weights, offsets and carrier; the offsets align the heads to within
    50 counts."""
    carrier = int(rng.integers(1, HEADS + 1))
    missing = int(rng.choice([head for head in range(HEADS + 1) if head != carrier]))
    weights = rng.integers(-20_000, 30_000, HEADS)
    if missing:
        weights[missing - 1] = 0
    weights[carrier - 1] = 0
    weights[carrier - 1] = WEIGHT_ONE - weights.sum()
    offsets = (zeros * 16 + rng.integers(-800, 800, HEADS)) % (16 * COUNTS)
    return MeanSet(tuple(weights.tolist()), tuple(offsets.tolist()), carrier, missing)


@cocotb.test()
async def the_count_goes_on_from_carrier_to_carrier(dut: Any) -> None:
    rng = np.random.default_rng(HEADS)
    await start(dut)
    position = motion(rng)
    # Position of each head's index; the offsets of each mean compensate the differences between the
    # heads.
    index = position[0] - rng.integers(0, COUNTS, HEADS)
    angle = (position - index) % COUNTS
    zeros = (position[0] - index) % COUNTS
    phases = rng.integers(0, 4, HEADS)
    alone = MeanSet((WEIGHT_ONE, *(0,) * (HEADS - 1)), (0,) * HEADS)
    active, idle = alone, alone
    sets: list[MeanSet] = []
    seen: list[Seen] = []
    swaps: list[int] = []
    queue: list[tuple[int, int]] = []
    dut.phases_of_zero.value = flat(phases, 2)
    dut.compensate.value = 1
    dut.indices_seen.value = 2**HEADS - 1
    for clock in range(CLOCKS):
        dut.angles.value = flat(angle[clock], ANGLE_WIDTH)
        dut.positions.value = flat(position[clock], POSITION_WIDTH)
        if clock % 250 == 60:
            idle = random_set(rng, zeros)
            queue = list(enumerate(idle.words()))
        dut.write_enable.value = int(bool(queue) and clock % 4 == 0)
        if queue and clock % 4 == 0:
            dut.write_address.value, dut.write_data.value = queue.pop(0)
        swap = clock % 250 == 200 + int(rng.integers(0, 3)) or clock % 250 == 203
        swap = swap and idle is not active
        dut.swap_comes.value = int(swap)
        dut.hold_writes.value = int(swap)
        sets.append(active)
        await RisingEdge(dut.clock)
        if swap:
            assert dut.may_swap.value == 1
            active = idle
            swaps.append(clock)
        seen.append(outputs(dut))
    assert len(swaps) == CLOCKS // 250
    assert {sets[swap + 1].carrier for swap in swaps} == set(range(1, HEADS + 1))
    compare(seen, sets, angle, position, swaps)


def compare(
    seen: list[Seen],
    sets: list[MeanSet],
    angle: NDArray[np.int64],
    position: NDArray[np.int64],
    swaps: list[int],
) -> None:
    """Check each output against the words and readings from which it follows, and check that the
    phase, and the difference of position and angle, stay constant."""
    between = 0
    for clock in range(10, CLOCKS - MEAN_LATENCY):
        mean, now = sets[clock], seen[clock]
        carrier = mean.carrier - 1
        wholes = whole_readings(angle[clock - CHOICE_CLOCKS], mean, COUNTS)
        assert now.carrier == carrier
        assert now.angle == wholes[carrier], f"clock {clock}"
        assert (now.apply, now.referenced) == (1, 1)
        later = seen[clock + MEAN_LATENCY]
        expected = weighted_mean(wholes[np.newaxis], mean, COUNTS).term[0]
        assert later.term == expected, f"clock {clock}"
        # The difference of position and angle, modulo a turn, is the same for all carriers.
        if clock == 10:
            between = (now.position - now.angle) % COUNTS
        assert (now.position - now.angle) % COUNTS == between, f"clock {clock}"
        assert now.phase == seen[10].phase
        is_first = clock - 1 in swaps
        assert later.jumped == is_first, f"clock {clock}"
        moved = position[clock - CHOICE_CLOCKS] - position[clock - 1 - CHOICE_CLOCKS]
        jump = later.jump if is_first else 0
        assert now.position - seen[clock - 1].position == moved[carrier] + jump, f"clock {clock}"
        assert abs(jump) < COUNTS // 2
    jumps = [abs(seen[swap + 1 + MEAN_LATENCY].jump) for swap in swaps[:-1]]
    assert max(jumps) > 20, "no jump is large enough to show that the position continues"


@cocotb.test()
async def applied_when_every_used_head_has_its_index(dut: Any) -> None:
    rng = np.random.default_rng(1)
    await start(dut)
    mean = MeanSet((0, WEIGHT_ONE, *(0,) * (HEADS - 2)), (0,) * HEADS, 2, 1)
    for number, word in enumerate(mean.words()):
        dut.write_address.value, dut.write_data.value = number, word
        dut.write_enable.value = 1
        await RisingEdge(dut.clock)
        dut.write_enable.value = 0
        while dut.write_acknowledge.value != 1:
            await RisingEdge(dut.clock)
    dut.swap_comes.value = 1
    await RisingEdge(dut.clock)
    dut.swap_comes.value = 0
    needed = sum(1 << head for head, used in enumerate(mean.used) if used)
    for _ in range(200):
        indices, wanted = int(rng.integers(0, 2**HEADS)), int(rng.integers(0, 2))
        dut.indices_seen.value = indices
        dut.compensate.value = wanted
        for _ in range(CHOICE_CLOCKS + 1):
            await RisingEdge(dut.clock)
        assert dut.apply.value == int(wanted and indices & needed == needed)
        assert dut.referenced.value == indices >> 1 & 1


@cocotb.test()
async def zeros_that_move_together_are_seen(dut: Any) -> None:
    """`zero_moved` toggles once in each clock in which zeros of heads move: of one head, of two
    heads, and of all."""
    await start(dut)
    zeros, before = 0, int(dut.zero_moved.value)
    for moves in (1, 3, 2, (1 << HEADS) - 1, 3, 1):
        zeros ^= moves
        dut.zeros_moved.value = zeros
        seen = []
        for _ in range(6):
            await RisingEdge(dut.clock)
            seen.append(int(dut.zero_moved.value))
        changes = [one != other for one, other in pairwise([before, *seen])]
        assert sum(changes) == 1, f"heads {moves:b}"
        before = seen[-1]


@cocotb.test()
async def a_swap_waits_for_what_moves_a_zero(dut: Any) -> None:
    """`may_swap` is low in the clock in which a zero may move and for eight clocks after it."""
    await start(dut)
    for _ in range(20):
        await RisingEdge(dut.clock)
    for name, value in (("zeros_moved", 1), ("indices_seen", 2), ("unsettle", 1)):
        assert dut.may_swap.value == 1
        getattr(dut, name).value = value
        waits = []
        for clock in range(20):
            await RisingEdge(dut.clock)
            waits.append(int(dut.may_swap.value == 0))
            if clock == 0 and name == "unsettle":
                dut.unsettle.value = 0
        assert waits == [1] * 9 + [0] * 11, name


@cocotb.test()
@cocotb.parametrize(after=[1, 2, 3])
async def counts_put_back_after_a_swap_make_no_step(dut: Any, after: int) -> None:
    """The new carrier gets 40 counts back, `after` clocks after the swap; the table is at rest.

    error_compensation withdraws `jump` at the first angle of new words, and the change of
    `put_back` at every other angle with a moved zero. The position minus the withdrawn counts must
    not change.
    """
    counts, step, first = [1000 + 7 * head for head in range(HEADS)], 40, 80
    put_backs = [13] + [0] * (HEADS - 1)
    weights = (0, WEIGHT_ONE, *(0,) * (HEADS - 2))
    alone = MeanSet((WEIGHT_ONE, *weights[2:], 0), (0,) * HEADS, 1, 2)
    mean = MeanSet(weights, (0,) * HEADS, 2, 1)
    await start(dut)
    dut.indices_seen.value = 2**HEADS - 1
    dut.compensate.value = 1
    queue: list[tuple[int, int]] = []
    moved = 0
    seen: list[tuple[Seen, int, int]] = []
    for clock in range(first + 30):
        if clock in (0, first // 2):
            queue = list(enumerate((alone if clock == 0 else mean).words()))
        dut.write_enable.value = int(bool(queue) and clock % 2 == 0)
        if queue and clock % 2 == 0:
            dut.write_address.value, dut.write_data.value = queue.pop(0)
        if clock == first + after:
            counts[1] += step
            put_backs[1] += step
            moved = 2
        dut.angles.value = flat(counts, ANGLE_WIDTH)
        dut.positions.value = flat(counts, POSITION_WIDTH)
        dut.put_backs.value = flat(put_backs, 16)
        dut.zeros_moved.value = moved
        swap = int(clock in (first // 2 - 1, first))
        dut.swap_comes.value, dut.hold_writes.value = swap, swap
        await RisingEdge(dut.clock)
        assert not swap or dut.may_swap.value == 1
        seen.append((outputs(dut), dut.put_back.value.to_signed(), int(dut.zero_moved.value)))
    jumps = 0
    for clock in range(first - 5, first + 10):
        (before, put_before, zero_before), (now, put_now, zero_now) = seen[clock - 1 : clock + 1]
        later = seen[clock + MEAN_LATENCY][0]
        withdrawn = put_now - put_before if zero_now != zero_before else 0
        if later.jumped:
            withdrawn, jumps = later.jump, jumps + 1
        assert now.position - before.position == withdrawn, f"clock {clock}"
    assert jumps == 1
    assert seen[-1][0].position - seen[first][0].position == 7 + step
