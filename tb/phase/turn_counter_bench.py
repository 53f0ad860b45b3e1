"""Compares turn_counter with its model, and with positions that do not wrap, in cocotb tests."""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from numpy.typing import NDArray

from arctrue.gateware.turn_counter import turn_numbers

COUNTS_PER_REV = int(os.environ.get("COUNTS_PER_REV", "5000"))
FOLD = int(os.environ.get("FOLD", "1"))


async def start(dut: Any, first: int = 0) -> None:
    dut.counts_per_rev.value = COUNTS_PER_REV
    dut.take.value = 1
    dut.angle.value = first
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(6):
        await RisingEdge(dut.clock)
    dut.reset.value = 0


async def play(dut: Any, angles: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Drive the angles; return `turn_select` and the turn number for each angle. Between two of
    these angles, the entity gets other angles with `take` low."""
    rng = np.random.default_rng(0)
    selects, turns = [], []
    clocks = FOLD * angles.size + 2
    for clock in range(clocks):
        place = clock // FOLD
        takes = clock % FOLD == 0 and place < angles.size
        dut.take.value = int(takes)
        dut.angle.value = int(angles[place] if takes else rng.integers(0, COUNTS_PER_REV))
        await RisingEdge(dut.clock)
        selects.append(int(dut.turn_select.value))
        turns.append(dut.turn.value.to_signed())
    # The bench reads values before the edge that ends a clock. `turn_select` is constant from the
    # clock after its angle to the next angle that is taken.
    first = np.arange(angles.size) * FOLD
    for later in range(1, FOLD + 1):
        assert np.array_equal(np.array(selects)[first + 1], np.array(selects)[first + later])
    return np.array(selects)[first + 1], np.array(turns)[np.minimum(first + 2, clocks - 1)]


async def check(dut: Any, total: NDArray[np.int64]) -> None:
    """Check that turn number and angle together give the counts ``total`` over many turns."""
    await start(dut, int(total[0] % COUNTS_PER_REV))
    angles = total % COUNTS_PER_REV
    selects, turns = await play(dut, angles)
    model = turn_numbers(angles, COUNTS_PER_REV)
    assert np.array_equal(turns, model)
    assert np.array_equal(selects, model % 4)
    assert np.array_equal(model, total // COUNTS_PER_REV - total[0] // COUNTS_PER_REV)


@cocotb.test()
async def forwards_and_backwards(dut: Any) -> None:
    """The turn number is right for steps of up to FOLD counts, and for much larger steps, in both
    directions over several turns."""
    rng = np.random.default_rng(1)
    for way in (1, -1):
        await check(dut, np.cumsum(way * rng.integers(0, FOLD + 1, 2000)) + 3)
        await check(dut, np.cumsum(way * rng.integers(0, COUNTS_PER_REV // 2, 500)))


@cocotb.test()
async def tremble_on_the_wrap(dut: Any) -> None:
    rng = np.random.default_rng(2)
    await check(dut, rng.integers(-FOLD, FOLD + 1, 3000))


@cocotb.test()
async def jumps_take_the_shorter_way(dut: Any) -> None:
    """If the angle jumps because the zero moves, the turn number follows the jump the shorter way
    round; a jump by exactly half a turn is no wrap."""
    rng = np.random.default_rng(3)
    angles = rng.integers(0, COUNTS_PER_REV, 2000)
    half = COUNTS_PER_REV // 2
    corners = [0, half, 0, half + 1, 0, COUNTS_PER_REV - half, COUNTS_PER_REV - 1, half - 1, 0]
    angles = np.concatenate([corners, angles])
    await start(dut, int(angles[0]))
    _, turns = await play(dut, angles)
    assert np.array_equal(turns, turn_numbers(angles, COUNTS_PER_REV))
    total = turns * COUNTS_PER_REV + angles
    assert np.abs(np.diff(total)).max() <= COUNTS_PER_REV / 2


@cocotb.test()
async def reset_begins_anew(dut: Any) -> None:
    await start(dut)
    await play(dut, np.arange(0, 3 * COUNTS_PER_REV, COUNTS_PER_REV // 3) % COUNTS_PER_REV)
    assert dut.turn.value.to_signed() == 2
    dut.take.value = 1
    dut.reset.value = 1
    for _ in range(3):
        await RisingEdge(dut.clock)
    assert dut.turn.value.to_signed() == 0
