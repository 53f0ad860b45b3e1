"""Tests in cocotb that the core with LOCAL_TABLE corrects the errors of scratches on the disc.

The correction is the value of a local table with four windows plus a sum of harmonics. For every
accepted angle it equals the correction of the models.
"""

from __future__ import annotations

from typing import Any

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles, FallingEdge
from cocotbext.axi import AxiResp
from numpy.typing import NDArray

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.compensation_pipeline import compensate
from arctrue.gateware.extension import POINTS
from arctrue.gateware.local_table import LocalTable
from arctrue.generated import registers
from arctrue.generated.number_formats import CORRECTION_FRACTION, PIPELINE_LATENCY
from tb.core import arctrue_core_table as table
from tb.core.arctrue_core_bench import CLOCKS_PER_COUNT, FOLD, LANES, Machine, prepared

COUNTS = table.COUNTS_PER_REV
HEIGHT = 9.0
"""Height of the largest scratch in counts; each window has one scratch."""
SIGNED = ("position", "correction", "corrected_position")
NAMES = ("angle", *SIGNED)
LATENCY = PIPELINE_LATENCY + FOLD - 1


def coefficients() -> Coefficients:
    return Coefficients.from_harmonics([1, 2, 5], [5.0, 6.0, 2.0], [0.4, -1.1, 2.0], COUNTS, LANES)


def scratches(sign: int) -> LocalTable:
    """Return a table with a smooth bump in each of its four windows of 1/16 turn; one window
    contains the zero."""
    place = np.arange(POINTS // 4) / (POINTS // 4)
    bump = sign * HEIGHT * np.sin(np.pi * place) ** 2
    points = np.rint(np.concatenate([bump, -bump, bump / 2.0, bump / 3.0]) * 2**10).astype(int)
    starts = (COUNTS - 20, COUNTS // 4, COUNTS // 2, 3 * COUNTS // 4)
    return LocalTable(COUNTS, starts, 4, 10, points)


async def settled(machine: Machine) -> None:
    await ClockCycles(machine.dut.clock, 2 * LATENCY)  # the ramp starts in this time
    while (await machine.registers.read_fields("status"))["ramp_busy"]:
        pass


async def turn_and_compare(machine: Machine, dut: Any, loaded: LocalTable | None) -> None:
    """Turn by 1.5 turns and compare the correction of every accepted angle with the model
    with ``loaded``."""
    seen: list[list[int]] = []
    turning = cocotb.start_soon(machine.turn(machine.now + turns(1.5)))
    pipeline = dut.unit.compensation
    while not turning.done():
        await FallingEdge(dut.clock)
        seen.append(
            [
                value.to_signed() if name in SIGNED else value.to_unsigned()
                for name, value in ((name, getattr(pipeline, name).value) for name in NAMES)
            ]
        )
    rows = np.array(seen, dtype=np.int64)[:-LATENCY]
    later = np.array(seen, dtype=np.int64)[LATENCY:]
    model = compensate(rows[:, 0], rows[:, 1], coefficients(), table=loaded)
    if FOLD == 1:
        assert np.array_equal(later[:, 2], model.correction)
        assert np.array_equal(later[:, 3], model.corrected_position)
    else:
        # Every FOLD-th angle is accepted; only for the right first angle do all outputs equal the
        # model's.
        same = [
            np.mean(later[start::FOLD, 2] == model.correction[start::FOLD]) for start in range(FOLD)
        ]
        assert sum(share == 1.0 for share in same) == 1, same
    if loaded is not None:
        # Check that the local table acts: it changes the correction by almost the height of its
        # largest bump.
        without = compensate(rows[:, 0], rows[:, 1], coefficients())
        added = (model.correction - without.correction) / 2.0**CORRECTION_FRACTION
        assert np.abs(added).max() > 0.9 * HEIGHT


def turns(number: float) -> NDArray[np.float64]:
    """Return the angle in counts at each clock of a motion over this number of turns."""
    return np.arange(int(number * COUNTS * CLOCKS_PER_COUNT)) / CLOCKS_PER_COUNT


@cocotb.test()
@cocotb.parametrize(signs=[1, 2])
async def scratches_are_taken_away(dut: Any, signs: int) -> None:
    """The correction equals the model's after each swap: for a new table, for new lanes only, for
    the inverse table (2 signs), and after the windows are disabled."""
    machine = await prepared(dut)
    names = machine.registers
    assert (await names.read_fields("capability"))["local_table"] == 1
    await names.write_coefficients(coefficients())
    await names.command("swap")
    await names.update("control", output_enable=1, compensate=1)
    await machine.turn(machine.now + turns(1.5))
    for sign in (1, -1)[:signs]:
        loaded = scratches(sign)
        await names.write_local_table(loaded)
        await names.command("swap")
        await settled(machine)
        await turn_and_compare(machine, dut, loaded)
        # Only the lanes are swapped; the table stays active.
        await names.write_coefficients(coefficients())
        await names.command("swap")
        await settled(machine)
        await turn_and_compare(machine, dut, loaded)
        assert await names.read("local_place.start2") == loaded.starts[1]
    await names.update("local_place.choice", enable=0)
    await names.command("swap")
    await settled(machine)
    await turn_and_compare(machine, dut, None)


@cocotb.test()
async def words_of_the_table(dut: Any) -> None:
    """The words of the table can be read back; the core refuses writes of parts of a word, and
    accesses beyond the table."""
    machine = await prepared(dut)
    bus = machine.bus
    first, place = registers.LOCAL_POINTS_ADDRESS, registers.LOCAL_PLACE_CHOICE_ADDRESS
    for address, word in ((first, 5), (first + 4 * 4095, -7), (place + 24, 0xFFFF)):
        assert await bus.write(address, word & 0xFFFF_FFFF) == AxiResp.OKAY
        assert await bus.read(address) == (AxiResp.OKAY, word & 0xFFFF_FFFF)
        assert await bus.write(address, 1, strobes=0b0011) == AxiResp.SLVERR
        assert await bus.read(address) == (AxiResp.OKAY, word & 0xFFFF_FFFF)
    assert await bus.write(place + 28, 1) == AxiResp.SLVERR
    for beyond in (place + 28, first + 4 * POINTS):
        assert await bus.read(beyond) == (AxiResp.SLVERR, 0)
