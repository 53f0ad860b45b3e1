"""Compares the strobes of position_compare with the clocks in which the position reaches its
compare places."""

from __future__ import annotations

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, FallingEdge

CLOCKS = 4000
LATENCY = 2


def places_reached(position: np.ndarray, first: int, interval: int) -> list[int]:
    """Return the clocks in which a place is reached; ``position`` has the position in each clock
    from `arm` on."""
    reached: list[int] = []
    below = position[0] < first
    place = None
    for clock, now in enumerate(position.tolist()):
        if place is None:
            if position[0] == first:
                is_reached = now != first
            else:
                is_reached = now >= first if below else now <= first
            if is_reached:
                reached.append(clock)
                place = first
                if not interval:
                    return reached
        elif now >= place + interval:
            reached.append(clock)
            place += interval
        elif now <= place - interval:
            reached.append(clock)
            place -= interval
    return reached


@cocotb.test()
@cocotb.parametrize(
    (
        ("first", "interval", "start"),
        [
            (50, 10, 0),
            (-30, 7, 0),
            (0, 13, 0),
            (40, 0, 0),
            (0, 0, 0),
            (5 - 2**31, 9, 2**31 - 40),
        ],
    )
)
async def at_every_multiple(dut, first: int, interval: int, start: int) -> None:
    """A strobe comes at the first place and then, with an interval, whenever the position is a
    whole interval from the last place. The position vibrates, goes up and down, and in the last
    case passes its wrap."""
    random = np.random.default_rng(7)
    way = np.repeat([1, -1, -1, 1], CLOCKS // 4)
    steps = way * (random.random(CLOCKS) < 0.4) - way * (random.random(CLOCKS) < 0.15)
    position = start + np.cumsum(steps)
    wrapped = (position + 2**31) % 2**32 - 2**31
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.reset.value = 1
    dut.arm.value = 0
    dut.disarm.value = 0
    dut.position.value = int(wrapped[0])
    dut.first.value = first
    dut.interval.value = interval
    await ClockCycles(dut.clock, 3, FallingEdge)
    dut.reset.value = 0
    await FallingEdge(dut.clock)
    assert not int(dut.armed.value)
    strobes = []
    for clock in range(CLOCKS):
        dut.position.value = int(wrapped[clock])
        dut.arm.value = int(clock == 0)
        await FallingEdge(dut.clock)
        if int(dut.strobe.value):
            strobes.append(clock)
    target = first + 2**32 if start > 2**30 else first
    expected = places_reached(position, target, interval)
    # The entity compares only from the second clock after `arm` on.
    late = [max(clock + LATENCY - 1, LATENCY) for clock in expected]
    assert strobes == [clock for clock in late if clock < CLOCKS]
    assert len(expected) == 1 if not interval else len(expected) > 10
    assert int(dut.armed.value) == (interval > 0)


@cocotb.test()
@cocotb.parametrize(sense=[1, -1], interval=[0, 10])
async def armed_on_its_place_it_waits_until_that_is_left(dut, sense: int, interval: int) -> None:
    """If the table stands at the first place and then vibrates by a count, one strobe comes, when
    the table leaves the place."""
    way = [0] * 30 + [sense] * 10 + [0] * 10 + [sense] * 10
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.reset.value = 1
    dut.arm.value = 0
    dut.disarm.value = 0
    dut.first.value = 5
    dut.interval.value = interval
    dut.position.value = 5
    await ClockCycles(dut.clock, 3, FallingEdge)
    dut.reset.value = 0
    strobes = []
    for clock, moved in enumerate(way):
        dut.position.value = 5 + moved
        dut.arm.value = int(clock == 0)
        await FallingEdge(dut.clock)
        if int(dut.strobe.value):
            strobes.append(clock)
        assert int(dut.armed.value) == (clock < 30 + LATENCY - 1 or interval > 0), clock
    assert strobes == [30 + LATENCY - 1]


@cocotb.test()
@cocotb.parametrize(sense=[1, -1])
async def catches_up_after_a_jump(dut, sense: int) -> None:
    """After a jump over the first place and seven further places, one strobe comes for each place.
    The strobes of the further places come every third clock; no strobe follows them."""
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.reset.value = 1
    dut.arm.value = 0
    dut.disarm.value = 0
    dut.position.value = -5 * sense
    dut.first.value = 0
    dut.interval.value = 10
    await ClockCycles(dut.clock, 3, FallingEdge)
    dut.reset.value = 0
    dut.arm.value = 1
    await FallingEdge(dut.clock)
    dut.arm.value = 0
    await ClockCycles(dut.clock, 5, FallingEdge)
    strobes = []
    dut.position.value = 73 * sense
    for clock in range(60):
        await FallingEdge(dut.clock)
        if int(dut.strobe.value):
            strobes.append(clock)
    assert len(strobes) == 8, "the first place and seven multiples"
    assert set(np.diff(strobes[1:])) == {3}


@cocotb.test()
@cocotb.parametrize(at_once=[False, True])
async def disarmed_it_is_silent(dut, at_once: bool) -> None:
    """After `disarm` no strobe comes, even if `arm` was high in the same clock; the next `arm`
    starts the comparison again."""
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.reset.value = 1
    dut.arm.value = 0
    dut.disarm.value = 0
    dut.position.value = 0
    dut.first.value = 5
    dut.interval.value = 10
    await ClockCycles(dut.clock, 3, FallingEdge)
    dut.reset.value = 0

    async def strobes_of(first: int, last: int) -> int:
        found = 0
        for position in range(first, last):
            dut.position.value = position
            await FallingEdge(dut.clock)
            dut.arm.value = 0
            dut.disarm.value = 0
            found += int(dut.strobe.value)
        return found

    dut.arm.value = 1
    assert await strobes_of(0, 40) == 4
    dut.arm.value = int(at_once)
    dut.disarm.value = 1
    assert await strobes_of(40, 80) == 0
    assert not int(dut.armed.value)
    dut.first.value = 85
    dut.arm.value = 1
    assert await strobes_of(80, 120) == 4
    assert int(dut.armed.value)
