"""Compares event_queue, clock by clock, with a Python list that follows the entity's header."""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

DELAY = int(os.environ["DELAY"])
COMPARE_DELAY = int(os.environ["COMPARE_DELAY"])
DEPTH = 2 ** int(os.environ["DEPTH_LOG2"])
CLOCKS = 6000
RESET_CLOCKS = 64
FIRST_TIME = 2**64 - 2000
"""First time stamp of the test, during which the time wraps."""
PHASES = ((0.05, 0.5), (0.5, 0.05), (0.0, 0.3), (0.9, 0.9), (0.02, 0.02))
"""Probabilities per clock of a strobe (the same for `probe` and `compare`) and of a `take`, for the
phases of the test: the queue is empty, full, being emptied, read while it is written, and rarely
used."""


def schedule(random: np.random.Generator, kind: int) -> np.ndarray:
    """Return for each clock whether a strobe or a `take` comes."""
    shares = np.repeat([phase[kind] for phase in PHASES], CLOCKS // len(PHASES))
    return random.random(CLOCKS) < shares


@cocotb.test()
async def every_event_is_shown_or_counted_as_lost(dut: Any) -> None:
    random = np.random.default_rng(11)
    strobes = {DELAY: schedule(random, 0), COMPARE_DELAY: schedule(random, 0)}
    take = schedule(random, 1)
    recorded = random.integers(0, 4, CLOCKS)[np.cumsum(random.random(CLOCKS) < 0.002)]
    recorded[: CLOCKS // 2] = 3
    position = random.integers(-(2**31), 2**31, CLOCKS)
    angle = random.integers(0, 2**24, CLOCKS)
    reset = np.zeros(CLOCKS, dtype=bool)
    for begin in (0, 3 * CLOCKS // 4):
        reset[begin : begin + RESET_CLOCKS] = True
    for strobe in strobes.values():
        strobe[reset] = False  # no strobe comes during a reset
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await FallingEdge(dut.clock)
    queue: list[tuple[int, int, int, int, int]] = []
    number = lost = 0
    seen = {"both": 0, "lost": 0, "read while written": 0, "taken": 0, "empty": 0}
    for clock in range(CLOCKS):
        dut.probe.value = int(strobes[DELAY][clock])
        dut.compare.value = int(strobes[COMPARE_DELAY][clock])
        dut.take.value = int(take[clock])
        dut.recorded.value = int(recorded[clock])
        dut.reset.value = int(reset[clock])
        dut.position.value = int(position[clock])
        dut.angle.value = int(angle[clock])
        dut.timestamp.value = (FIRST_TIME + clock) % 2**64
        await FallingEdge(dut.clock)
        shown = queue[0] if queue else None
        kind = 0
        for bit, delay in enumerate((DELAY, COMPARE_DELAY)):
            kind |= int(clock >= delay and strobes[delay][clock - delay]) << bit
        kind &= int(recorded[clock])
        was_full = len(queue) == DEPTH
        taken = bool(take[clock]) and bool(queue)
        if reset[clock]:
            queue, number, lost, shown = [], 0, 0, None
        else:
            queue = queue[taken:]
            if kind and not was_full:
                time = (FIRST_TIME + clock - DELAY) % 2**64
                queue.append((kind, number, time, int(position[clock]), int(angle[clock])))
            seen["both"] += kind == 3
            seen["lost"] += bool(kind) and was_full
            seen["read while written"] += bool(kind) and taken
            seen["taken"] += taken
            seen["empty"] += bool(take[clock]) and not taken
            lost = (lost + (bool(kind) and was_full)) % 2**16
            number = (number + bool(kind)) % 2**16
        assert dut.kind.value.to_unsigned() == (shown[0] if shown else 0), clock
        if shown:
            assert (
                dut.number.value.to_unsigned(),
                dut.event_time.value.to_unsigned(),
                dut.event_position.value.to_signed(),
                dut.event_angle.value.to_unsigned(),
            ) == shown[1:], clock
        assert dut.waiting.value.to_unsigned() == len(queue), clock
        assert dut.lost.value.to_unsigned() == lost, clock
    assert min(seen.values()) > 20, seen
