"""Compares the VHDL decoder with its model, in every clock of every scenario."""

from __future__ import annotations

import os
from dataclasses import fields

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, FallingEdge, RisingEdge, Timer
from sim.tests.gateware.quadrature_decoder_scenarios import Stimuli, scenarios_to_run, stimuli

from arctrue.gateware.quadrature_decoder import (
    DecoderInputs,
    DecoderTrace,
    quadrature_decoder,
)

# The generics with which the decoder was built.
STAGES = int(os.environ["SYNCHRONISER_STAGES"])
RESET_POSITION = int(os.environ["RESET_POSITION"])
DEFAULT_GENERICS = (STAGES, RESET_POSITION) == (2, 0)

OUTPUTS = [field.name for field in fields(DecoderTrace)]
# IDLE_CLOCKS exceeds the latency of every pipeline and filter: no output changes after this number
# of clocks with constant inputs.
IDLE_CLOCKS = 400


def checked_clocks(given: Stimuli) -> np.ndarray:
    """Return a mask of the clocks in which outputs are read: those within IDLE_CLOCKS after a
    change of the inputs."""
    inputs = np.column_stack(list(given.columns.values()))
    changes = np.concatenate([[True], (np.diff(inputs, axis=0) != 0).any(axis=1)])
    last_change = np.maximum.accumulate(np.where(changes, np.arange(len(inputs)), 0))
    return np.arange(len(inputs)) - last_change < IDLE_CLOCKS


async def play(dut, given: Stimuli) -> dict[str, np.ndarray]:
    """Drive the stimuli; return every output and, under "clock", the numbers of the clocks after
    which the outputs are read."""
    columns = {key: column.tolist() for key, column in given.columns.items()}
    timestamps = given.timestamp.tolist()
    handles = [getattr(dut, name) for name in OUTPUTS]
    drivers = {key: getattr(dut, key) for key in columns}
    last: dict[str, int] = {}
    rows = []
    idle = 0
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await FallingEdge(dut.clock)
    for clock, is_checked in enumerate(checked_clocks(given).tolist()):
        if not is_checked:
            idle += 1
            continue
        if idle:
            await ClockCycles(dut.clock, idle, FallingEdge)
            idle = 0
        for key, column in columns.items():
            if column[clock] != last.get(key):
                last[key] = column[clock]
                drivers[key].value = column[clock]
        dut.timestamp.value = timestamps[clock]
        await FallingEdge(dut.clock)
        rows.append([clock, *(int(handle.value) for handle in handles)])
    return dict(zip(["clock", *OUTPUTS], np.array(rows, dtype=np.uint64).T, strict=True))


@cocotb.test()
@cocotb.parametrize(name=scenarios_to_run(DEFAULT_GENERICS))
async def follows_the_model(dut, name: str) -> None:
    given = stimuli(name)
    got = await play(dut, given)
    inputs = DecoderInputs(**given.columns, timestamp=given.timestamp)
    model = quadrature_decoder(inputs, STAGES, RESET_POSITION)
    clock = got["clock"].astype(np.int64)
    for output in OUTPUTS:
        # Compare the bits of the output, so that it does not matter whether it is signed.
        bits = np.uint64(2 ** len(getattr(dut, output)) - 1)
        expected = getattr(model, output)[clock + 1].astype(np.uint64) & bits
        wrong = np.flatnonzero(got[output] != expected)
        assert not wrong.size, (
            f"{output}: first of {wrong.size} differences from the model after clock "
            f"{clock[wrong[0]]}: {got[output][wrong[0]]}, model {expected[wrong[0]]}"
        )


async def wait(clocks: int) -> None:
    """Wait for ``clocks`` clocks with a timer, which is faster than awaiting each edge."""
    await Timer(10 * clocks, "ns")


async def begin(dut, counts_per_rev: int) -> None:
    """Start a clock with a period of 10 ns and reset the decoder; return in the middle of a
    clock."""
    inputs = (
        "a",
        "b",
        "z",
        "minimum_edge_spacing",
        "index_tolerance",
        "timestamp",
        "clear",
        "rearm",
        "zero_again",
        "heal",
        "other_head_agrees",
    )
    Clock(dut.clock, 10, unit="ns", impl="gpi").start(start_high=False)
    for name in inputs:
        getattr(dut, name).value = 0
    dut.counts_per_rev.value = counts_per_rev
    dut.filter_length.value = 1
    dut.reset.value = 1
    await ClockCycles(dut.clock, 8)
    dut.reset.value = 0
    await FallingEdge(dut.clock)
    await ClockCycles(dut.clock, 8, FallingEdge)


@cocotb.test(skip=not DEFAULT_GENERICS)
async def long_turn_at_an_edge_every_clock(dut) -> None:
    # The number of counts per turn is neither a power of two nor a multiple of 4; the disc makes
    # two whole turns, from the first to the third index mark.
    turn = 70_001
    await begin(dut, turn)
    Clock(dut.a, 40, unit="ns", impl="gpi").start()
    await Timer(10, "ns")
    Clock(dut.b, 40, unit="ns", impl="gpi").start()
    seen = []
    for mark in range(3):
        if mark:
            await wait(turn - 6 - 1)
        dut.z.value = 1
        await RisingEdge(dut.index_strobe)
        await FallingEdge(dut.clock)
        # The decoder reports the mark after the next step, when the position has advanced by a
        # second step.
        seen.append(dut.index_position.value.to_signed())
        assert dut.position.value.to_signed() == seen[-1] + 2
        assert dut.angle.value.to_unsigned() == 2
        dut.z.value = 0
    assert np.diff(seen).tolist() == [turn, turn]
    assert dut.index_error.value == 0
