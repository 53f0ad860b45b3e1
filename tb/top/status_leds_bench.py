"""Compares the LEDs in each window of clocks with the random states in the previous window."""

from __future__ import annotations

import random
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

HOLD_LOG2 = 3
WINDOW = 2**HOLD_LOG2
WINDOWS = 400
STATES = ("capturing", "fault", "compensating")
LEDS = ("led_capture", "led_fault", "led_compensation")


async def start(dut: Any) -> None:
    for name in STATES:
        getattr(dut, name).value = 0
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(3):
        await FallingEdge(dut.clock)
    dut.reset.value = 0


def lit(dut: Any) -> tuple[int, ...]:
    return tuple(int(getattr(dut, name).value) for name in LEDS)


@cocotb.test()
async def a_window_shows_what_the_one_before_saw(dut: Any) -> None:
    await start(dut)
    chance = random.Random(5)
    levels = [0, 0, 0]
    before = (0, 0, 0)
    single_clocks = 0
    for window in range(WINDOWS):
        seen = [0, 0, 0]
        for clock in range(WINDOW):
            for place, name in enumerate(STATES):
                # Most events last one or a few clocks; each state has an event in about every
                # second window.
                levels[place] = int(chance.random() < (0.5 if levels[place] else 0.06))
                getattr(dut, name).value = levels[place]
                seen[place] += levels[place]
            assert lit(dut) == before, f"window {window}, clock {clock}"
            assert int(dut.led_alive.value) == window // 8 % 2
            await FallingEdge(dut.clock)
        single_clocks += seen.count(1)
        before = tuple(int(clocks > 0) for clocks in seen)
    assert single_clocks > 100


@cocotb.test()
async def reset_puts_all_out(dut: Any) -> None:
    await start(dut)
    for name in STATES:
        getattr(dut, name).value = 1
    for _ in range(12 * WINDOW):
        await FallingEdge(dut.clock)
    assert (lit(dut), int(dut.led_alive.value)) == ((1, 1, 1), 1)
    dut.reset.value = 1
    for _ in range(2):
        await FallingEdge(dut.clock)
        assert (lit(dut), int(dut.led_alive.value)) == ((0, 0, 0), 0)
    for name in STATES:
        getattr(dut, name).value = 0
    dut.reset.value = 0
    # A reset clears the recorded events.
    for _ in range(3 * WINDOW):
        await FallingEdge(dut.clock)
        assert lit(dut) == (0, 0, 0)
