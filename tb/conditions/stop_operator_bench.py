"""Compares stop_operator with its model, clock by clock, in cocotb tests."""

from __future__ import annotations

import random
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.stop_operator import STOP_LATENCY, StopOperator


async def start(dut: Any, width: int, dead_zone: int) -> None:
    for name, value in (("position", 0), ("put_back", 0), ("width", width)):
        getattr(dut, name).value = value
    dut.dead_zone.value = dead_zone
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(8):
        await RisingEdge(dut.clock)
    dut.reset.value = 0
    for _ in range(8):
        await RisingEdge(dut.clock)


async def follow(dut: Any, positions: list[int], put_backs: list[int]) -> list[tuple[int, bool]]:
    """Drive one reading in each clock; return the outputs ``place`` and ``known`` that belong to
    each reading."""
    found = []
    last = len(positions) - 1
    for clock in range(len(positions) + STOP_LATENCY):
        dut.position.value = positions[min(clock, last)]
        dut.put_back.value = put_backs[min(clock, last)] & 0xFFFF
        await RisingEdge(dut.clock)
        found.append((dut.place.value.to_signed(), bool(dut.known.value)))
    return found[STOP_LATENCY:]


@cocotb.test()
async def every_clock_as_the_model(dut: Any) -> None:
    """The outputs equal the model's in every clock, while the position vibrates, steps by up to 8
    counts, jumps, and has lost counts put back."""
    generator = random.Random(28)
    for width, dead_zone in ((0, 0), (16 * 40, 0), (16 * 25 + 5, 4), (16 * 60, 255), (3, 1)):
        await start(dut, width, dead_zone)
        model = StopOperator(width, dead_zone)
        model.move(0)
        position, put_back, positions, put_backs = 0, 0, [], []
        side = 1
        for _ in range(3000):
            if generator.random() < 0.02:
                side = -side
            position += generator.choice([0, 0, side, side, -side, 3 * side, 8 * side])
            if generator.random() < 0.01:
                jump = generator.randint(-900, 900)
                position, put_back = position + jump, put_back + jump
            if generator.random() < 0.005:
                position += generator.choice([-1, 1]) * generator.randint(9, 30_000)
            positions.append(position & 0xFFFF_FFFF)
            put_backs.append(put_back)
        # The entity counts modulo 2^16, the model without a wrap; both get the same positions.
        signed = [(p ^ 1 << 31) - (1 << 31) for p in positions]
        expected = [model.move(p, b) for p, b in zip(signed, put_backs, strict=True)]
        found = await follow(dut, signed, put_backs)
        assert found == expected
        assert any(known for _, known in found)


@cocotb.test()
async def a_new_width_makes_it_unknown(dut: Any) -> None:
    """After a travel of twice the width W to one side, `place` is W and `known` is high; a new
    width makes `known` low again."""
    await start(dut, 16 * 10, 0)
    found = await follow(dut, list(range(1, 21)), [0] * 20)
    assert found[-1] == (160, True)
    assert found[-2][1] is False, "the place is known after 19 of 20 counts"
    dut.width.value = 16 * 12
    await RisingEdge(dut.clock)
    await RisingEdge(dut.clock)
    assert not dut.known.value
    found = await follow(dut, [20, *range(21, 45)], [0] * 25)
    assert found[-1] == (192, True)
    assert found[-2][1] is False
