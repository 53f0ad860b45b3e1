"""Alarm and driver enable, clock by clock, against the header's words."""

from __future__ import annotations

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

CLOCKS = 8000
KINDS = 5


@cocotb.test()
async def at_random(dut) -> None:
    random = np.random.default_rng(3)

    def held(share: float, mean: int) -> np.ndarray:
        changes = np.cumsum(random.random(CLOCKS) < 1 / mean)
        return (random.random(CLOCKS + 1) < share)[changes]

    bits = 1 << np.arange(KINDS)
    present = (np.stack([held(0.1, 9) for _ in range(KINDS)], axis=1) * bits).sum(axis=1)
    alarms = random.integers(0, 1 << KINDS, CLOCKS)[np.cumsum(random.random(CLOCKS) < 0.01)]
    releases = random.integers(0, 1 << KINDS, CLOCKS)[np.cumsum(random.random(CLOCKS) < 0.01)]
    enable, clear = held(0.8, 60), random.random(CLOCKS) < 0.05
    reset = random.random(CLOCKS) < 0.005
    reset[0] = True
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await FallingEdge(dut.clock)
    released = False
    driven = np.zeros(CLOCKS, dtype=bool)
    for clock in range(CLOCKS):
        dut.reset.value = int(reset[clock])
        dut.enable.value = int(enable[clock])
        dut.clear.value = int(clear[clock])
        dut.present.value = int(present[clock])
        dut.alarm_sources.value = int(alarms[clock])
        dut.release_sources.value = int(releases[clock])
        await FallingEdge(dut.clock)
        fatal = bool(present[clock] & releases[clock])
        if reset[clock] or not enable[clock]:
            released = False
        elif fatal:
            released = True
        elif clear[clock]:
            released = False
        assert int(dut.released.value) == released, clock
        driven[clock] = enable[clock] and not released and not reset[clock] and not fatal
        assert int(dut.driver_enable.value) == driven[clock], clock
        alarm = bool(present[clock] & alarms[clock]) and not reset[clock]
        assert int(dut.alarm.value) == alarm, clock
    assert 0.1 < driven.mean() < 0.9
