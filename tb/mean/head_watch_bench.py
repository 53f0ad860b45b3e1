"""Tests in cocotb the three checks by which head_watch detects a failed head; models predict the
results of two of them."""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from numpy.typing import NDArray

from arctrue.gateware.head_watch import FailoverCause, MissingEdges, StepSearch
from arctrue.generated.number_formats import WATCH_SETTLE_CLOCKS
from tb.support.flat import flat

HEADS = int(os.environ.get("HEADS", "4"))
INTERVAL_BITS = int(os.environ.get("INTERVAL_BITS", "5"))
WIDTH = 17
ALL_CAUSES = 0x3F
FLAGS = ("illegals", "overspeeds", "swallowed", "index_errors")
COUNTS = ("illegal_counts", "overspeed_counts", "index_error_counts")


async def start(dut: Any) -> None:
    for name in (*FLAGS, *COUNTS, "steps", "steps_up", "differences", "restart", "step_limit"):
        getattr(dut, name).value = 0
    dut.missing_counts.value = 0
    dut.causes_wanted.value = ALL_CAUSES
    dut.watching.value = 1
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(4):
        await RisingEdge(dut.clock)
    dut.reset.value = 0


def shown(dut: Any) -> tuple[int, int]:
    return dut.failed.value.to_unsigned(), dut.causes.value.to_unsigned()


@cocotb.test()
async def a_new_fault_of_a_decoder_fails_its_head(dut: Any) -> None:
    """A head is reported once when its flag rises and once for each increment of its counter, if
    the cause is enabled."""
    await start(dut)
    bits = {"illegals": 0, "overspeeds": 1, "swallowed": 2, "index_errors": 5}
    for flag, bit in bits.items():
        for head in range(HEADS):
            for wanted in (1, 0):
                dut.causes_wanted.value = ALL_CAUSES if wanted else ALL_CAUSES & ~(1 << bit)
                getattr(dut, flag).value = 1 << head
                seen = []
                for _ in range(6):
                    await RisingEdge(dut.clock)
                    seen.append(shown(dut))
                assert seen.count((1 << head, 1 << bit)) == wanted
                assert seen.count((0, 0)) == 6 - wanted
                if flag != "swallowed":
                    counter = getattr(dut, flag[:-1] + "_counts")
                    counter.value = 1 << head
                    seen = []
                    for _ in range(6):
                        await RisingEdge(dut.clock)
                        seen.append(shown(dut))
                    assert seen.count((1 << head, 1 << bit)) == wanted
                    counter.value = 0
                getattr(dut, flag).value = 0
                for _ in range(3):
                    await RisingEdge(dut.clock)


@cocotb.test()
async def flags_from_before_watching_fail_no_head(dut: Any) -> None:
    await start(dut)
    dut.watching.value = 0
    dut.illegals.value = 1
    for _ in range(5):
        await RisingEdge(dut.clock)
    dut.watching.value = 1
    for _ in range(10):
        await RisingEdge(dut.clock)
        assert shown(dut) == (0, 0)


@cocotb.test()
async def missing_edges_equal_the_model(dut: Any) -> None:
    """Entity and model report a dead head in the same clock, and report no head while the table
    only vibrates."""
    rng = np.random.default_rng(HEADS)
    await start(dut)
    limit = 48
    dut.missing_counts.value = limit
    model = MissingEdges(HEADS)
    dead = 0
    deaths: set[int] = set()
    shown_later = [0, 0]
    moving, dead_head = np.ones(HEADS, dtype=bool), -1
    way = 1
    for clock in range(6000):
        if clock % 600 == 0:
            dead_head = clock // 600 % (HEADS + 1) - 1
            moving = np.arange(HEADS) != dead_head
            way = 0 if dead_head < 0 else int(rng.choice([-1, 1]))
        to = way if way else int(rng.choice([-1, 1]))
        steps = np.where((rng.random(HEADS) < 0.5) & moving, to, 0).astype(np.int64)
        dut.steps.value = flat(np.abs(steps), 1)
        dut.steps_up.value = flat((steps > 0).astype(np.int64), 1)
        await RisingEdge(dut.clock)
        # `failed` reports a head one clock after the clock in which the model finds it dead.
        found = model.clock(steps, limit, watching=True)
        dead = sum(1 << head for head in np.flatnonzero(found))
        failed, causes = shown(dut)
        expected = shown_later.pop(0)
        assert failed == expected, f"clock {clock}"
        assert causes == (1 << FailoverCause.MISSING_EDGES if expected else 0)
        shown_later.append(dead)
        deaths |= {head for head in range(HEADS) if failed >> head & 1}
    assert deaths == set(range(HEADS))


def readings(rng: np.random.Generator, clocks: int) -> NDArray[np.int64]:
    """Return differences to head 1 (clocks, heads) that change periodically, with steps of one head
    and sometimes of two heads at once."""
    phase = np.arange(clocks)[:, np.newaxis] / 900.0 + rng.uniform(0, 6.0, HEADS)
    rows = 40.0 * np.sin(phase)
    for clock in range(500, clocks, 700):
        for _ in range(1 if rng.random() < 0.8 else 2):
            head = int(rng.integers(0, HEADS))
            rows[clock : clock + 400, head] += rng.choice([-1.0, 1.0]) * rng.integers(10, 4000)
    rows -= rows[:, [0]]
    return np.rint(rows).astype(np.int64)


@cocotb.test()
async def steps_equal_the_model(dut: Any) -> None:
    """Entity and model report the same head in the same clock, for steps of 10 to 4,000 counts and
    with restarts."""
    rng = np.random.default_rng(10 + HEADS)
    await start(dut)
    limit = 32
    dut.step_limit.value = limit
    model = StepSearch(HEADS, INTERVAL_BITS)
    rows = readings(rng, 12_000)
    later: list[int] = [0, 0]
    names: set[int] = set()
    # The first rows have a restart, at which model and entity start together.
    for clock, row in enumerate(rows):
        restart = clock < 3 or clock % 2500 == 1700
        dut.restart.value = int(restart)
        dut.differences.value = flat(row, WIDTH)
        await RisingEdge(dut.clock)
        found = model.clock(row, limit, restart=restart)
        failed, causes = shown(dut)
        expected = later.pop(0)
        assert failed == expected, f"clock {clock}"
        assert causes == (1 << FailoverCause.STEP if expected else 0)
        later.append(0 if found is None else 1 << found)
        names |= {head for head in range(HEADS) if failed >> head & 1}
    assert names == set(range(HEADS)), f"heads {names} were found"


@cocotb.test()
async def a_step_of_twice_the_limit_is_always_found(dut: Any) -> None:
    """A step of at least twice the limit is always found, and attributed to the right head, if the
    axis changes each difference by less than the limit."""
    rng = np.random.default_rng(3)
    await start(dut)
    limit = 32
    dut.step_limit.value = limit
    for case in range(60):
        head = int(rng.integers(0, HEADS))
        motion = rng.integers(0, limit, HEADS)
        step = int(rng.choice([-1, 1])) * (2 * limit + int(rng.integers(0, 3)))
        row = rng.integers(-3000, 3000, HEADS)
        row -= row[0]
        dut.restart.value = 1
        dut.differences.value = flat(row, WIDTH)
        await RisingEdge(dut.clock)
        dut.restart.value = 0
        for _ in range(WATCH_SETTLE_CLOCKS + 20):
            await RisingEdge(dut.clock)
        steps = motion.copy()
        for jump, expected in ((0, 0), (step, 1 << head)):
            steps[head] = motion[head] + jump
            moved = row + steps
            dut.differences.value = flat(moved - moved[0], WIDTH)
            seen = set()
            for _ in range(30):
                await RisingEdge(dut.clock)
                seen.add(shown(dut)[0])
            assert seen - {0} == ({expected} if expected else set()), f"case {case}"
