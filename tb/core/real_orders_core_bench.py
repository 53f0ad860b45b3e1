"""Tests in cocotb that the core with REAL_ORDERS corrects errors of real (non-integer) orders.

The table turns forwards and backwards over several turns. The correction of every accepted angle
equals that of the model for the turn in which the table then is.
"""

from __future__ import annotations

from typing import Any

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles, FallingEdge
from cocotbext.axi import AxiResp
from numpy.typing import NDArray

from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.compensation_pipeline import compensate
from arctrue.gateware.turn_counter import turn_numbers
from arctrue.generated import registers
from arctrue.generated.number_formats import PHASE_STEP_WIDTH, PIPELINE_LATENCY
from tb.core import arctrue_core_table as table
from tb.core.arctrue_core_bench import FOLD, LANES, Machine, prepared

COUNTS = table.COUNTS_PER_REV
CLOCKS_PER_COUNT = 2.5
TURN = 1 << PHASE_STEP_WIDTH
ORDERS = (0.5, 2.4, 3.0, 0.398)
AMPLITUDES = (5.0, 4.0, 6.0, 3.0)
SIGNED = ("position", "correction", "corrected_position", "turn")
NAMES = ("angle", *SIGNED)
LATENCY = PIPELINE_LATENCY + FOLD - 1


def bank(orders: tuple[float, ...] = ORDERS) -> Coefficients:
    made = Coefficients.from_harmonics(
        [0] * LANES, list(AMPLITUDES), [0.4, -1.1, 2.0, 0.1], COUNTS, LANES
    )
    steps = tuple((lane, round(order % 1 * TURN)) for lane, order in enumerate(orders) if order % 1)
    return Coefficients(
        np.array([round(order * TURN / COUNTS) for order in orders], dtype=np.uint64),
        made.phase_offsets,
        made.amplitudes,
        0,
        COUNTS,
        None,
        Extension(turn_steps=steps),
    )


async def record(machine: Machine, dut: Any, angle: NDArray[np.float64]) -> NDArray[np.int64]:
    """Turn the table by ``angle``; return the signals NAMES in every clock, (clocks, names)."""
    seen: list[list[int]] = []
    turning = cocotb.start_soon(machine.turn(angle))
    pipeline = dut.unit.compensation
    while not turning.done():
        await FallingEdge(dut.clock)
        seen.append(
            [
                value.to_signed() if name in SIGNED else value.to_unsigned()
                for name, value in ((name, getattr(pipeline, name).value) for name in NAMES)
            ]
        )
    return np.array(seen, dtype=np.int64)


def compare(rows: NDArray[np.int64], loaded: Coefficients) -> None:
    """Check that the correction of every accepted angle equals that of the model in this angle's
    turn."""
    seen, later = rows[:-LATENCY], rows[LATENCY:]
    # The turn number comes two clocks after its angle, and an angle is accepted every FOLD clocks;
    # so row 2·FOLD contains the turn number of one of the first angles, which are all in the same
    # turn.
    turns = turn_numbers(seen[:, 0], COUNTS, int(rows[2 * FOLD, 4]))
    model = compensate(seen[:, 0], seen[:, 1], loaded, turns=turns)
    same = [
        np.array_equal(later[start::FOLD, 2], model.correction[start::FOLD])
        and np.array_equal(later[start::FOLD, 3], model.corrected_position[start::FOLD])
        for start in range(FOLD)
    ]
    assert sum(same) == 1, same
    assert np.ptp(turns) >= 2


async def settled(machine: Machine) -> None:
    await ClockCycles(machine.dut.clock, 60 * LANES + 2 * LATENCY)
    while (await machine.registers.read_fields("status"))["ramp_busy"]:
        pass


@cocotb.test()
async def lines_of_real_orders(dut: Any) -> None:
    """The correction equals the model's over three turns forwards and three backwards, over three
    turns with another bank, and with integer orders."""
    machine = await prepared(dut)
    names = machine.registers
    assert (await names.read_fields("capability"))["real_orders"] == 1
    loaded = bank()
    await names.write_coefficients(loaded)
    await names.command("swap")
    await names.update("control", output_enable=1, compensate=1)
    turn = np.arange(int(COUNTS * CLOCKS_PER_COUNT)) / CLOCKS_PER_COUNT
    await machine.turn(machine.now + turn)
    await machine.turn(machine.now + turn)
    await settled(machine)
    before, passed = await names.read("turn_number"), machine.pair[0] // COUNTS
    up = machine.now + np.concatenate([turn, COUNTS + turn, 2 * COUNTS + turn])
    down = up[-1] - np.concatenate([turn, COUNTS + turn, 2 * COUNTS + turn, 3 * COUNTS + turn[:9]])
    tremble = down[-1] + 3.0 * np.sin(np.arange(900) / 20.0)
    compare(await record(machine, dut, np.concatenate([up, down, tremble])), loaded)
    number = await names.read("turn_number")
    assert number == before + machine.pair[0] // COUNTS - passed
    other = bank((1.7, 0.25, 0.5, 1.0))
    await names.write_coefficients(other)
    await names.command("swap")
    await settled(machine)
    up = machine.now + np.concatenate([turn, COUNTS + turn, 2 * COUNTS + turn])
    compare(await record(machine, dut, up), other)
    assert (await names.read("turn_number")) == number + 3
    whole = Coefficients.from_harmonics([1, 2], [5.0, 3.0], [0.3, 1.0], COUNTS, LANES)
    await names.write_coefficients(whole)
    await names.command("swap")
    await settled(machine)
    up = machine.now + np.concatenate([turn, COUNTS + turn, 2 * COUNTS + turn[:9]])
    compare(await record(machine, dut, up), whole)


@cocotb.test()
async def rearm_keeps_the_turn(dut: Any) -> None:
    """After a re-arm and the next index, the turn numbers continue as without the re-arm."""
    machine = await prepared(dut)
    names = machine.registers
    turn = np.arange(int(COUNTS * CLOCKS_PER_COUNT)) / CLOCKS_PER_COUNT
    await machine.turn(machine.now + turn)
    for share in (0.2, 0.5):
        await machine.turn(machine.now + turn[: int(turn.size * share)])
        before = await names.read("turn_number")
        await names.command("rearm")
        await ClockCycles(dut.clock, 200)
        await machine.turn(machine.now + turn)
        await machine.turn(machine.now + turn)
        # The table has made two turns since, so the turn number is larger by two.
        assert (await names.read("turn_number")) == before + 2


@cocotb.test()
async def words_of_turn_steps(dut: Any) -> None:
    """Words of turn steps can be read back; the core refuses lanes that are not built, writes of
    parts of a word, and writes to the turn number."""
    machine = await prepared(dut)
    bus = machine.bus
    first = registers.TURN_STEPS_ADDRESS
    for lane in range(LANES):
        for word, data, kept in ((0, 0xDEADBEEF, 0xDEADBEEF), (1, 0xFFFF1234, 0x1234)):
            address = first + 8 * lane + 4 * word
            assert await bus.write(address, data) == AxiResp.OKAY
            assert await bus.read(address) == (AxiResp.OKAY, kept)
            assert await bus.write(address, 1, strobes=0b0011) == AxiResp.SLVERR
            assert await bus.read(address) == (AxiResp.OKAY, kept)
            assert await bus.write(address, 0) == AxiResp.OKAY
    for beyond in (first + 8 * LANES, first + 508, first + 0x204, first + 0x3FC):
        assert await bus.write(beyond, 1) == AxiResp.SLVERR
        assert await bus.read(beyond) == (AxiResp.SLVERR, 0)
    assert await bus.write(registers.TURN_NUMBER_ADDRESS, 1) == AxiResp.SLVERR
