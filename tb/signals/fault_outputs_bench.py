"""Compares `alarm` and `driver_enable`, clock by clock, with the rules in the entity's header."""

from __future__ import annotations

import os

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

CLOCKS = 8000
KINDS = 5
HOLD = int(os.environ["HOLD"])


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
    causes, cleared, driver, since_reset, resets = 0, False, False, HOLD, False
    driven = np.zeros(CLOCKS, dtype=bool)
    for clock in range(CLOCKS):
        dut.reset.value = int(reset[clock])
        dut.enable.value = int(enable[clock])
        dut.clear.value = int(clear[clock])
        dut.present.value = int(present[clock])
        dut.alarm_sources.value = int(alarms[clock])
        dut.release_sources.value = int(releases[clock])
        await FallingEdge(dut.clock)
        fatal = int(present[clock] & releases[clock])
        if reset[clock] or not enable[clock]:
            causes = 0
        elif cleared:
            causes = fatal
        else:
            causes |= fatal
        cleared = bool(clear[clock]) and not reset[clock]
        # From the first clock of a reset on, `driver_enable` keeps its level for HOLD clocks or
        # until `enable` is high.
        if reset[clock] and not resets and since_reset >= HOLD:
            since_reset = 0
        elif enable[clock] and not reset[clock]:
            since_reset = HOLD
        resets = bool(reset[clock])
        holds, since_reset = since_reset < HOLD, since_reset + 1
        assert int(dut.released.value) == bool(causes), clock
        assert dut.causes.value.to_unsigned() == causes, clock
        driver = driver if holds else bool(enable[clock] and not causes and not reset[clock])
        driven[clock] = driver
        assert int(dut.driver_enable.value) == driven[clock], clock
        alarm = bool(present[clock] & alarms[clock]) and not reset[clock]
        assert int(dut.alarm.value) == alarm, clock
    assert 0.1 < driven.mean() < 0.9


@cocotb.test()
@cocotb.parametrize(kind=range(KINDS), ends=[True, False])
async def one_clear_is_enough(dut, kind: int, ends: bool) -> None:
    """A `clear` ends the release of the drivers, even if the fault ends one clock later; if the
    fault lasts longer, the drivers stay released."""
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.reset.value = 1
    dut.enable.value, dut.clear.value, dut.present.value = 1, 0, 0
    dut.alarm_sources.value, dut.release_sources.value = 0, 1 << kind
    await FallingEdge(dut.clock)
    dut.reset.value = 0
    await FallingEdge(dut.clock)
    assert int(dut.driver_enable.value) == 1
    dut.present.value = 1 << kind
    await FallingEdge(dut.clock)
    assert (int(dut.driver_enable.value), int(dut.released.value)) == (0, 1)
    dut.clear.value = 1
    await FallingEdge(dut.clock)
    dut.clear.value = 0
    dut.present.value = 0 if ends else 1 << kind
    for _ in range(3):
        await FallingEdge(dut.clock)
        assert (int(dut.driver_enable.value), int(dut.released.value)) == (ends, not ends)
        assert dut.causes.value.to_unsigned() == (0 if ends else 1 << kind)


@cocotb.test()
@cocotb.parametrize(reset_clocks=[1, HOLD // 2], released=[0, 1])
async def a_reset_keeps_the_drivers_for_a_while(dut, reset_clocks: int, released: int) -> None:
    """A reset keeps the state of the drivers until `enable` is high, or for HOLD clocks from its
    start.

    Released drivers stay released: a reset does not enable them.
    """
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.clear.value, dut.present.value = 0, 0
    dut.alarm_sources.value, dut.release_sources.value = 0, 1
    for enabled_after in (reset_clocks, HOLD - 1, HOLD + 7):
        dut.enable.value = 0
        await FallingEdge(dut.clock)
        dut.enable.value = 1
        dut.reset.value = 0
        for clock in range(HOLD + 9):
            dut.present.value = int(released and clock == HOLD + 5)
            await FallingEdge(dut.clock)
        assert int(dut.driver_enable.value) == 1 - released
        seen = []
        for clock in range(HOLD + 20):
            dut.reset.value = int(clock < reset_clocks)
            dut.enable.value = int(clock >= enabled_after)
            await FallingEdge(dut.clock)
            seen.append(int(dut.driver_enable.value))
        gap = [not clock < HOLD and clock < enabled_after for clock in range(HOLD + 20)]
        expected = [
            int(clock >= enabled_after or (not released and not is_gap))
            for clock, is_gap in enumerate(gap)
        ]
        assert seen == expected, enabled_after
