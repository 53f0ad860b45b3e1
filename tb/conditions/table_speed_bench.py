"""Compares table_speed with its model, clock by clock, in cocotb tests."""

from __future__ import annotations

import random
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.table_speed import SPEED_LATENCY, Measured, TableSpeed

WINDOW, LONGEST = 6, 10


def drive(generator: random.Random, clocks: int) -> list[tuple[int, int]]:
    """Return corrected position and correction for each clock; the motion has many speeds,
    standstills with and without vibration, and reversals."""
    rows, place, speed, left, error = [], 1000.0, 0.0, 0, 0.0
    for _ in range(clocks):
        if left == 0:
            left = generator.randint(20, 2500)
            speed = generator.choice([0.0, 0.0, 0.9, 0.1, 0.01, 0.002, 6.0])
            speed *= generator.choice([-1, 1])
        left -= 1
        tremble = generator.choice([0.0, 0.0, 0.7, -0.7]) if speed == 0.0 else 0.0
        place += speed
        error = 40.0 + 3.0 * ((place / 200.0) % 1.0)
        reading = round(place + tremble)
        correction = round(error * 2048)
        rows.append((reading - ((correction + 1024) >> 11), correction))
    return rows


@cocotb.test()
async def every_clock_as_the_model(dut: Any) -> None:
    generator = random.Random(30)
    rows = drive(generator, 30_000)
    dut.position.value, dut.correction.value = rows[0]
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(6):
        await RisingEdge(dut.clock)
    dut.reset.value = 0
    found: list[Measured | None] = []
    for clock in range(len(rows) + SPEED_LATENCY):
        dut.position.value, dut.correction.value = rows[min(clock, len(rows) - 1)]
        await RisingEdge(dut.clock)
        if not dut.measured.value:
            found.append(None)
            continue
        found.append(
            Measured(
                int(dut.travel.value),
                bool(dut.is_down.value),
                bool(dut.is_bound.value),
                int(dut.elapsed.value),
            )
        )
    model = TableSpeed(WINDOW, LONGEST)
    # The entity counts the clocks from the end of the reset; it gets the first row two clocks
    # later.
    for _ in range(SPEED_LATENCY - 1):
        model.move(*rows[0])
    expected = [model.move(*row) for row in rows]
    found = found[SPEED_LATENCY:]
    apart = [n for n, pair in enumerate(zip(found, expected, strict=True)) if pair[0] != pair[1]]
    assert not apart, [(n, found[n], expected[n]) for n in apart[:4]]
    kinds = {(one.is_bound, one.is_down, one.travel == 0) for one in found if one}
    assert len(kinds) >= 6, kinds
