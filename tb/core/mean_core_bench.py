"""Tests the core with the weighted mean in cocotb: drives all heads' pins and checks the position.

The table has heads at known places, a disc with an error, and an axis that moves. Each head
measures the motion of the axis in its own direction, so each single reading has an error, which
cancels in the mean.
"""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles, FallingEdge
from numpy.typing import NDArray

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.latency import pipeline_clocks
from arctrue.gateware.mean_set import WEIGHT_ONE, MeanSet
from arctrue.gateware.quadrature_decoder import latency_clocks
from arctrue.gateware.register_access import RegisterMap
from tb.core import arctrue_core_table as table
from tb.registers.axi_lite import start

HEADS = int(os.environ.get("HEADS", "2"))
LANES = 2
"""Number of lanes: one for each order of DISC."""
CAPTURE_DEPTH = 64
COUNTS = table.COUNTS_PER_REV
CLOCKS_PER_COUNT = 6.0
PLACES = {2: (0, 300), 3: (0, 190, 410), 4: (0, 55, 271, 501)}[HEADS]
"""Counts by which each head reads ahead of head 1; four heads: 0, 33, 162.6 and 300.6 degrees."""
if os.environ.get("ANY_HEAD_MAY_FAIL"):
    PLACES = {3: PLACES, 4: (0, 107, 295, 430)}[HEADS]
    """Places in counts; four heads are at about 0, 64.3, 177 and 257.9 degrees, where the weights
    of any three heads are within the gateware's range."""
DISC = ((2, 1.5, -1.1), (5, 0.6, 2.0))
MOTION = ((1, 5.0, 0.3), (3, 4.0, 1.7))
"""Order per turn, radius in counts and phase of each circle of the axis' motion."""
INTERRUPTS = [f"head{head}_{event}" for event in ("index", "fault") for head in (3, 4)]
LATENCY = pipeline_clocks(heads=HEADS)
PINS = [f"head{head}_{pin}" for head in range(1, HEADS + 1) for pin in "abz"]
AHEAD = 4096
"""Number of clocks for which the bench calculates the readings in one step."""
OUTPUT_STEP = {0b00: 0, 0b01: 1, 0b11: 2, 0b10: 3}


def turn_rad(counts: Any) -> Any:
    return 2.0 * np.pi * np.asarray(counts, dtype=np.float64) / COUNTS


def readings(angle: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return readings (n, heads), each from the head's index, at these table angles in counts."""
    columns = []
    for place in PLACES:
        seen = angle + place
        error = sum(a * np.cos(n * turn_rad(seen) + p) for n, a, p in DISC)
        moved = sum(r * np.cos(n * turn_rad(angle) + p - turn_rad(place)) for n, r, p in MOTION)
        columns.append(seen + error + moved)
    return np.rint(np.column_stack(columns)).astype(np.int64)


def mean_of(heads: tuple[int, ...], carrier: int) -> MeanSet:
    """Return the mean of ``heads`` (numbers from 1 on), in which a motion of the axis cancels if
    there are two opposite heads or at least three heads. The weight of the carrier absorbs the
    rounding of the weights."""
    places = turn_rad([PLACES[head - 1] for head in heads])
    rows = np.array([np.ones(len(heads)), np.cos(places), np.sin(places)])
    words = [0] * HEADS
    for head, weight in zip(heads, np.linalg.pinv(rows) @ [1.0, 0.0, 0.0], strict=True):
        words[head - 1] = round(weight * WEIGHT_ONE)
    words[carrier - 1] += WEIGHT_ONE - sum(words)
    missing = next((head for head in range(1, HEADS + 1) if head not in heads), 0)
    return MeanSet(tuple(words), tuple(16 * place for place in PLACES), carrier, missing)


def lanes_of(mean: MeanSet) -> Coefficients:
    """Return the coefficients of E, the error of the mean: for each harmonic of the disc, the
    weighted sum of the heads' errors."""
    shares = np.array(mean.weights) / WEIGHT_ONE
    seen = [
        (n, a * np.exp(1j * p) * np.sum(shares * np.exp(1j * n * turn_rad(PLACES))))
        for n, a, p in DISC
    ]
    return Coefficients.from_harmonics(
        [n for n, _ in seen],
        [abs(value) for _, value in seen],
        [float(np.angle(value)) for _, value in seen],
        COUNTS,
        LANES,
    )


class Table:
    """Drives the core with a turning table; logs true angle, corrected position and output in each
    clock."""

    def __init__(self, dut: Any, registers: RegisterMap) -> None:
        self.dut = dut
        self.registers = registers
        self.pins = [getattr(dut, name) for name in PINS]
        self.levels: list[tuple[int, ...]] = [()] * HEADS
        self.now = -150.0
        self.angle: list[float] = []
        self.corrected: list[int] = []
        self.output: list[int] = []
        self.stands: set[int] = set()
        """Numbers of the heads that are dead: their pins keep their levels."""
        self.shown: list[int] = [0] * HEADS
        self.moves = True
        self.slips: list[int] = [0] * HEADS
        """Counts by which A and B of each head have slipped; the index does not slip."""
        self.bursts: list[int] = [0] * HEADS
        """Counts by which each head has still to slip, one count every two clocks in which no head
        counts."""

    def slip(self, head: int) -> None:
        """Slip A and B of a head by one more count, as noise on its signals might."""
        if self.bursts[head]:
            way = 1 if self.bursts[head] > 0 else -1
            self.slips[head] += way
            self.bursts[head] -= way

    def drive(self, row: list[int]) -> None:
        for head, reading in enumerate(row):
            if head + 1 not in self.stands:
                self.shown[head] = reading
        for head, (reading, slip) in enumerate(zip(self.shown, self.slips, strict=True)):
            pins = table.pins(reading + slip) & 0b11 | table.pins(reading) & 0b100
            levels = tuple(pins >> bit & 1 for bit in range(3))
            if levels != self.levels[head]:
                for pin, level in zip(self.pins[3 * head :], levels, strict=False):
                    pin.value = level
                self.levels[head] = levels

    async def run(self) -> None:
        """Turn the table without end, unless ``moves`` is false, and log every clock."""
        last: list[int] = []
        falling = FallingEdge(self.dut.clock)
        corrected = self.dut.unit.corrected_position
        out_a, out_b = self.dut.out_a, self.dut.out_b
        ahead = [self.now]
        rows: list[list[int]] = []
        place = 0
        while True:
            if place == len(rows):
                steps = np.full(AHEAD + 1, 1.0 / CLOCKS_PER_COUNT)
                steps[0] = ahead[-1]
                angles = np.add.accumulate(steps)
                ahead, rows, place = angles.tolist(), readings(angles[:-1]).tolist(), 0
            self.now, row = ahead[place], rows[place]
            if len(self.angle) % 2 and row == last[:HEADS]:
                for head in range(HEADS):
                    self.slip(head)
            if [*row, *self.slips] != last:
                self.drive(row)
                last = [*row, *self.slips]
            await falling
            self.angle.append(self.now)
            self.corrected.append(corrected.value.to_signed())
            phase = OUTPUT_STEP[int(out_a.value) | int(out_b.value) << 1]
            before = self.output[-1] if self.output else phase
            step = (phase - before + 1) % 4 - 1
            assert step != 2, "the output changed A and B together"
            self.output.append(before + step)
            place += self.moves

    async def turn(self, counts: float) -> None:
        await ClockCycles(self.dut.clock, int(counts * CLOCKS_PER_COUNT))

    def error(self, first: int, delay: int = 0) -> NDArray[np.float64]:
        """Return the error of the corrected position in counts, from clock ``first`` on."""
        angle = np.array(self.angle[first - delay : len(self.angle) - delay])
        return np.array(self.corrected[first:]) - angle


async def prepared(dut: Any) -> Table:
    for name in PINS:
        getattr(dut, name).value = 0
    machine_start = readings(np.array([-150.0]))[0].tolist()
    levels = [table.pins(reading) >> bit & 1 for reading in machine_start for bit in range(3)]
    for name, level in zip(PINS, levels, strict=True):
        getattr(dut, name).value = level
    bus = await start(dut, reset_clocks=64)
    machine = Table(dut, bus.registers())
    names = machine.registers
    await names.write("counts_per_rev", COUNTS)
    await names.command("rearm")
    await names.write("ramp_rate", 0xFFFF_FFFF)
    await names.write("ramp_acceleration", 0)
    await names.write("output_spacing", 1)
    await names.write("sample_period", 64)
    await ClockCycles(dut.clock, 200)
    return machine


async def load(machine: Table, mean: MeanSet) -> None:
    """Load the mean and the lanes with one swap, and wait for the end of the ramp."""
    names = machine.registers
    await names.write_coefficients(lanes_of(mean))
    await names.write_mean(mean)
    await names.command("swap")
    await machine.turn(150)
    assert await names.read("status.ramp_busy") == 0


LARGEST_STEP = 2
"""Largest permitted step of the corrected position per clock, in counts: one count of the carrier,
and one from the rounding of the other heads.

At six clocks per count, no head counts a second time while the ramp holds the correction after a
swap. Without the ramp, a change of the carrier would step the output by the difference of the
heads, 4 to 9 counts.
"""
POSITION_CLOCKS = latency_clocks()
"""Number of clocks from the pins to a head's position."""


def mean_bound(mean: MeanSet) -> float:
    """Return the largest difference between the corrected position and the table's angle, apart
    from a constant.

    It is the sum of four parts: the rounding of each head, half a count times its weight; the
    rounding of the output, half a count; the evaluation of E at the carrier's reading, up to 10
    counts from the table's angle, 10 counts times the slope of E; and 0.01 count for the rounding
    of amplitudes and phases.
    """
    slope = sum(2.0 * np.pi * n * a / COUNTS for n, a, _ in DISC)
    return sum(map(abs, mean.weights)) / WEIGHT_ONE * 0.5 + 0.5 + 10.0 * slope + 0.01


def check_mean(machine: Table, first: int, mean: MeanSet) -> None:
    """Check that the corrected position equals the table's angle up to a constant and
    mean_bound()."""
    bound = mean_bound(mean)
    error = machine.error(first, LATENCY + POSITION_CLOCKS)
    error -= round(float(np.median(error)) / COUNTS) * COUNTS
    spread = (error.max() - error.min()) / 2.0
    assert spread <= bound, f"{spread:.2f} counts of {bound:.2f}"
    machine.dut._log.info(f"off by {spread:.2f} counts at most, bound {bound:.2f}")


@cocotb.test()
async def the_mean_is_blind_to_the_axis(dut: Any) -> None:
    """Head 1 alone has the error that the motion of the axis causes; the mean follows the table,
    whichever head is the carrier."""
    machine = await prepared(dut)
    names = machine.registers
    assert await names.read_fields("capability") == {
        "heads": HEADS,
        "mean": 1,
        "rotation": 0,
        "modulators": 0,
        "real_orders": 0,
        "local_table": 0,
        "failover": 0,
        "events": 0,
    }
    assert await names.read("pipeline.latency") == LATENCY
    cocotb.start_soon(machine.run())
    await names.update("control", compensate=1, output_enable=1)
    await machine.turn(COUNTS + 150)
    # At power-up the mean consists of head 1 alone.
    error = machine.error(len(machine.corrected) - 3000, LATENCY + POSITION_CLOCKS)
    assert (error.max() - error.min()) / 2.0 > 6.0
    everyone = tuple(range(1, HEADS + 1))
    began = len(machine.corrected)
    for carrier in map(int, os.environ["CARRIERS"].split()):
        mean = mean_of(everyone, carrier)
        await load(machine, mean)
        assert await names.read("status.compensating") == 1
        first = len(machine.corrected)
        await machine.turn(COUNTS)
        check_mean(machine, first, mean)
    steps = np.abs(np.diff(machine.corrected[began:]))
    assert steps.max() <= LARGEST_STEP, "a change of the carrier stepped the output"
    followed = np.array(machine.corrected[began:]) - np.array(machine.output[began:])
    assert followed.max() - followed.min() <= 4


@cocotb.test(skip=len(os.environ.get("CARRIERS", "").split()) < 4)
async def three_heads_go_on_without_the_first(dut: Any) -> None:
    """Head 1, the carrier, dies; after a swap to words without head 1, the output is right and
    makes no step."""
    machine = await prepared(dut)
    names = machine.registers
    cocotb.start_soon(machine.run())
    await names.update("control", compensate=1, output_enable=1)
    await machine.turn(COUNTS + 150)
    await load(machine, mean_of((1, 2, 3, 4), 1))
    without = mean_of((2, 3, 4), 3)
    # As in a failover, the words are written before head 1 fails, and the swap follows the failure
    # at once.
    await names.write_coefficients(lanes_of(without))
    await names.write_mean(without)
    began = len(machine.corrected)
    machine.stands = {1}
    await names.command("swap")
    await machine.turn(150)
    first = len(machine.corrected)
    await machine.turn(COUNTS)
    check_mean(machine, first, without)
    assert np.abs(np.diff(machine.corrected[began:])).max() <= LARGEST_STEP


@cocotb.test()
async def a_head_is_delayed(dut: Any) -> None:
    """With a delay of one head, each sample contains this head's reading of ``delay`` clocks before
    the readings of the other heads.

    ``tb/top/arctrue_zynq_heads_bench.py`` captures all heads without a delay.
    """
    delay = 41
    machine = await prepared(dut)
    names = machine.registers
    await names.update("head_delays", **{f"head{HEADS}": delay})
    cocotb.start_soon(machine.run())
    await machine.turn(COUNTS + 150)
    await names.update("control", capture_enable=1)
    await machine.turn(COUNTS + 100)
    machine.moves = False
    bank = await names.read_capture(HEADS)
    await names.update("head_delays", **{f"head{HEADS}": 0})
    assert bank.samples.shape[1] == HEADS
    assert len(bank.samples) > 50
    assert bank.flags["index_seen1"]
    assert bank.flags["index_seen2"]
    assert bank.flags["further_index_seen"] == (HEADS > 2)
    rows = readings(np.array(machine.angle)) % COUNTS
    late = np.column_stack([rows[delay:, :-1], rows[:-delay, -1:]])
    known = {tuple(row) for row in late.tolist()}
    assert all(tuple(row) in known for row in (bank.samples % COUNTS).tolist())


@cocotb.test(skip=HEADS == 2)
async def further_heads_have_registers(dut: Any) -> None:
    """Heads 3 and 4 have registers for snapshot, flags and pin settings like heads 1 and 2."""
    machine = await prepared(dut)
    names = machine.registers
    cocotb.start_soon(machine.run())
    await machine.turn(COUNTS + 150)
    assert await names.read("heads_status.index_seen") == 2**HEADS - 1
    seen = []
    for _ in range(20):
        snapshot = await names.snapshot()
        row = [snapshot.head1_turn_position, snapshot.head2_turn_position]
        row += [await names.read(f"head{head}.turn_position") for head in range(3, HEADS + 1)]
        seen.append(row)
        angle = await names.read(f"head{HEADS}.angle")
        assert angle == row[-1] % COUNTS
        edge = await names.read(f"head{HEADS}.edge_time")
        assert 0 <= snapshot.time - edge < 3 * CLOCKS_PER_COUNT
    known = {tuple(row) for row in (readings(np.array(machine.angle)) % COUNTS).tolist()}
    assert all(tuple(np.array(row) % COUNTS) in known for row in seen), (
        "a snapshot with values of several clocks"
    )

    machine.moves = False
    await ClockCycles(dut.clock, 20)
    pins = [f"head{HEADS}_{pin}" for pin in "ab"]
    for name in pins:
        getattr(dut, name).value = 1 - int(getattr(dut, name).value)
    await ClockCycles(dut.clock, 20)
    flags = await names.read_fields(f"head{HEADS}.flags")
    assert (flags["index_seen"], flags["illegal"]) == (1, 1)
    assert await names.read(f"head{HEADS}.faults.illegals") == 1
    await names.write_raw("heads_command", 1 << (HEADS - 3))
    assert await names.read(f"head{HEADS}.flags.illegal") == 0
    before = await names.read(f"head{HEADS}.flags.direction")
    await names.update(f"head{HEADS}.pins", swap_ab=1)
    assert (await names.read_fields(f"head{HEADS}.pins"))["swap_ab"] == 1
    await ClockCycles(dut.clock, 20)
    machine.moves = True
    await machine.turn(20)
    assert await names.read(f"head{HEADS}.flags.direction") == 1 - before
    await names.update(f"head{HEADS}.pins", swap_ab=0)


@cocotb.test(skip=HEADS == 2)
async def a_fault_of_a_further_head_raises_the_alarm(dut: Any) -> None:
    """A fault of the last head raises the alarm, releases the drivers and raises the interrupt,
    each only if this head's bit is set."""
    machine = await prepared(dut)
    names = machine.registers
    cocotb.start_soon(machine.run())
    await names.clear_interrupts(*INTERRUPTS)
    assert not any([await names.read(f"interrupt_status.{name}") for name in INTERRUPTS])
    await machine.turn(COUNTS + 150)
    seen = {name: await names.read(f"interrupt_status.{name}") for name in INTERRUPTS}
    assert seen == {
        **{f"head{head}_index": int(head <= HEADS) for head in (3, 4)},
        **{f"head{head}_fault": 0 for head in (3, 4)},
    }
    machine.moves = False
    await ClockCycles(dut.clock, 20)
    fault = 1 << (3 + HEADS)
    await names.update("alarm", sources=0xFF ^ fault, released_by=0xFF ^ fault)
    await names.update("control", output_enable=1)
    await names.update("interrupt_enable", **{f"head{HEADS}_fault": 1})
    await ClockCycles(dut.clock, 4)
    assert (int(dut.alarm.value), int(dut.driver_enable.value), int(dut.interrupt.value)) == (
        0,
        1,
        0,
    )
    for pin in "ab":
        level = getattr(dut, f"head{HEADS}_{pin}")
        level.value = 1 - int(level.value)
    await ClockCycles(dut.clock, 20)
    assert int(dut.interrupt.value) == 1
    assert int(dut.status_fault.value) == 1
    assert (int(dut.alarm.value), int(dut.driver_enable.value)) == (0, 1), (
        "an alarm or a release without its bit"
    )
    await names.update("alarm", sources=fault, released_by=fault)
    await ClockCycles(dut.clock, 4)
    assert (int(dut.alarm.value), int(dut.driver_enable.value)) == (1, 0)
    status = await names.read_fields("status")
    assert (status["release_causes"], status["release_present"]) == (fault, fault)
    await names.write_raw("heads_command", 1 << (HEADS - 3))
    await names.command("clear_output")
    await ClockCycles(dut.clock, 4)
    assert (int(dut.alarm.value), int(dut.driver_enable.value)) == (0, 1)
    assert (await names.read_fields("status"))["release_causes"] == 0
