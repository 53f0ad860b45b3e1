"""Compares local_table in VHDL with its model, while the bank changes from angle to angle."""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from arctrue.gateware.extension import FRACTION_BITS, POINTS
from arctrue.gateware.local_table import LocalTable, local_table
from arctrue.generated.number_formats import LOCAL_TABLE_LATENCY

COUNTS_PER_REV = int(os.environ["COUNTS_PER_REV"])
ANGLES = 4000


def random_table(random: np.random.Generator, windows: int, width: int) -> LocalTable:
    """Return a random table whose windows do not overlap. One window contains the zero of the
    angle; the points are random in their whole format of 18 bits."""
    spacing = COUNTS_PER_REV // windows
    first = COUNTS_PER_REV - 3 if width else int(random.integers(COUNTS_PER_REV))
    starts = tuple((first + number * spacing) % COUNTS_PER_REV for number in range(windows))
    points = random.integers(-(2**17), 2**17, POINTS)
    fraction = int(random.choice(FRACTION_BITS))
    return LocalTable(COUNTS_PER_REV, starts, width, fraction, points)


def some_angles(random: np.random.Generator, tables: list[LocalTable]) -> np.ndarray:
    """Return angles around the ends of every window, and random angles."""
    near = np.arange(-6, 7)
    ends = [
        start + side + near
        for table in tables
        for start in table.starts
        for side in (0, -(-COUNTS_PER_REV // 2**table.width))
    ]
    angles = np.concatenate([*ends, random.integers(0, COUNTS_PER_REV, ANGLES)])
    return random.permutation(angles % COUNTS_PER_REV)


async def load(dut: Any, bank: int, table: LocalTable) -> None:
    for name, value in (
        ("enable", (1 << len(table.starts)) - 1),
        ("windows", len(table.starts).bit_length() - 1),
        ("width", table.width),
        ("fraction", FRACTION_BITS.index(table.fraction)),
        ("step", table.step),
    ):
        getattr(dut, f"bank{bank}_{name}").value = value
    for number in range(4):
        start = table.starts[number] if number < len(table.starts) else 0
        getattr(dut, f"bank{bank}_start{number + 1}").value = start
    dut.write_enable.value = 1
    dut.write_bank.value = bank
    for place, word in enumerate(table.points.tolist()):
        dut.write_address.value = place
        dut.write_data.value = word
        await FallingEdge(dut.clock)
    dut.write_enable.value = 0


@cocotb.test()
@cocotb.parametrize(kind=[0, 1, 2])
async def follows_the_model(dut: Any, kind: int) -> None:
    """The outputs equal the model's for tables of one, two and four windows, which cover the whole
    turn or a part of it."""
    random = np.random.default_rng(kind)
    shapes = ([(1, 0), (2, 1)], [(4, 2), (1, 3)], [(2, 4), (4, 6)])[kind]
    tables = [random_table(random, *shape) for shape in shapes]
    angles = some_angles(random, tables)
    banks = random.integers(0, 2, angles.size)
    for name in ("angle", "bank", "write_enable", "write_bank", "write_address", "write_data"):
        getattr(dut, name).value = 0
    dut.counts_per_rev.value = COUNTS_PER_REV
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await FallingEdge(dut.clock)
    for bank, table in enumerate(tables):
        await load(dut, bank, table)
    seen = []
    for clock in range(angles.size + LOCAL_TABLE_LATENCY):
        at = min(clock, angles.size - 1)
        dut.angle.value = int(angles[at])
        dut.bank.value = int(banks[at])
        await FallingEdge(dut.clock)
        seen.append(dut.value.value)
    found = np.array(
        [
            word.to_signed()
            for word in seen[LOCAL_TABLE_LATENCY - 1 : LOCAL_TABLE_LATENCY - 1 + angles.size]
        ]
    )
    expected = np.where(banks == 0, *(local_table(angles, table) for table in tables))
    wrong = np.flatnonzero(found != expected)
    assert not wrong.size, (
        f"angle {angles[wrong[0]]}, bank {banks[wrong[0]]}: {found[wrong[0]]}, expected "
        f"{expected[wrong[0]]} ({wrong.size} of {angles.size} differ)"
    )
    # Check that some angles lie inside windows, and some outside if the windows do not cover the
    # turn.
    assert (expected != 0).any()
    if kind:
        assert (expected == 0).sum() > 100
