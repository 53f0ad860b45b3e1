"""Tests the whole core in cocotb, from its input pins and AXI4-Lite bus to its output pins."""

from __future__ import annotations

import os
import random
from collections.abc import Sequence

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles, FallingEdge, RisingEdge
from cocotbext.axi import AxiResp
from numpy.typing import NDArray

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.compensation_pipeline import compensate
from arctrue.gateware.harmonic_lane import Rotation
from arctrue.gateware.register_access import RegisterMap
from arctrue.generated import number_formats, registers
from tb.core import arctrue_core_table as table
from tb.registers.axi_lite import Bus, start

LANES = 4
FOLD = int(os.environ.get("FOLD", "1"))
EVENTS = "EVENTS" in os.environ
ROTATION: Rotation = "table" if os.environ.get("ROTATION") == "table" else "cordic"
LOSSES = [(1, False), (0, True), (0, False), (1, True)]
"""Values of ``heal`` and ``head2_dead`` for the test of lost counts."""
CAPTURE_DEPTH = 64
SAMPLE_PERIOD = 50
CLOCKS_PER_COUNT = 5.0
FASTEST_RAMP = 0xFFFF_FFFF

HEAD_PINS = ("head1_a", "head1_b", "head1_z", "head2_a", "head2_b", "head2_z")
OUTPUT_STEP = {0b00: 0, 0b01: 1, 0b11: 2, 0b10: 3}  # index of levels (B, A) in counting order


class Machine:
    """Drives the core's pins with a turning table, decodes its output pins, and logs both in every
    clock."""

    def __init__(self, dut, bus: Bus) -> None:
        self.dut = dut
        self.bus = bus
        self.out_a, self.out_b, self.out_z = dut.out_a, dut.out_b, dut.out_z
        self.corrected_position = dut.unit.corrected_position
        self.index_scatter: tuple[int, ...] = (0,)
        self.registers: RegisterMap = bus.registers()
        self.now = table.START_COUNTS
        self.pair = readings_at(table.START_COUNTS)
        self.angle: list[float] = []
        self.reading: list[tuple[int, int]] = []
        self.corrected: list[int] = []
        self.output: list[int] = []
        self.z: list[int] = []
        self.stuck_at: int | None = None
        """Reading of head 1 at which its wires stop for a period of four counts; None if they never
        stop."""
        self.head2_stands = False
        self.head2 = 0
        self.first_time = -1

    async def turn(self, angle: NDArray[np.float64]) -> None:
        """Drive the readings for ``angle``, the table's angle in counts in each clock."""
        for now, pair in zip(angle.tolist(), table.readings(angle).tolist(), strict=True):
            if tuple(pair) != self.pair:
                self.pair = tuple(pair)
                self.head2 = self.head2 if self.head2_stands else self.pair[1]
                drive(self.dut, (self.shown(self.pair[0]), self.head2), self.index_scatter)
            self.now = now
            await FallingEdge(self.dut.clock)

    def shown(self, reading: int) -> int:
        """Return the reading that the levels on the wires of head 1 show."""
        if self.stuck_at is not None and self.stuck_at <= reading < self.stuck_at + 4:
            return self.stuck_at
        return reading

    async def log_every_clock(self) -> None:
        while True:
            await FallingEdge(self.dut.clock)
            if self.first_time < 0:
                self.first_time = int(self.dut.unit.timestamp.value)
            self.log()

    def log(self) -> None:
        self.angle.append(self.now)
        self.reading.append(self.pair)
        phase = OUTPUT_STEP[int(self.out_a.value) | int(self.out_b.value) << 1]
        if self.output:
            step = (phase - self.output[-1] + 1) % 4 - 1
            assert step != 2, "the output changed A and B together"
            self.output.append(self.output[-1] + step)
        else:
            self.output.append(phase)
        self.z.append(int(self.out_z.value))
        self.corrected.append(self.corrected_position.value.to_signed())


def readings_at(angle_counts: float) -> tuple[int, int]:
    head1, head2 = table.readings(np.array([angle_counts]))[0].tolist()
    return head1, head2


def drive(dut, pair: tuple[int, int], index_scatter: Sequence[int] = (0,)) -> None:
    levels = table.pins(pair[0], index_scatter) | table.pins(pair[1], index_scatter) << 3
    for place, name in enumerate(HEAD_PINS):
        getattr(dut, name).value = levels >> place & 1


async def prepared(dut, *, stall: float = 0.0, seed: int = 0) -> Machine:
    """Reset the core while the pins have their first levels, and set the turn and the ramp of the
    test."""
    drive(dut, readings_at(table.START_COUNTS))
    bus = await start(dut, reset_clocks=64)
    if stall:
        bus.stall(random.Random(seed), stall)
    machine = Machine(dut, bus)
    names = machine.registers
    await names.write("counts_per_rev", table.COUNTS_PER_REV)
    await names.command("rearm")
    await names.write("sample_period", SAMPLE_PERIOD)
    await names.write("ramp_rate", FASTEST_RAMP)
    await names.write("ramp_acceleration", 0)
    await names.write("output_spacing", 1)
    await ClockCycles(dut.clock, 200)
    cocotb.start_soon(machine.log_every_clock())
    return machine


async def clear_coefficients(machine: Machine) -> None:
    """Load coefficients of zero, because the coefficient banks survive a reset."""
    await machine.registers.write_coefficients(Coefficients.zero(table.COUNTS_PER_REV, LANES))
    await machine.registers.command("swap")


def check_samples(machine: Machine, start_time: int, samples: NDArray[np.int32]) -> None:
    """Check that each sample has the readings of both heads in one clock, ``SAMPLE_PERIOD`` clocks
    after the sample before it."""
    reading = np.array(machine.reading)
    first = start_time - machine.first_time
    for delay in range(12):  # the possible latencies from pins to position
        expected = reading[first - delay :: SAMPLE_PERIOD][: len(samples)]
        if len(expected) == len(samples) and np.array_equal(expected, samples):
            return
    expected = reading[first::SAMPLE_PERIOD][: len(samples)]
    raise AssertionError(f"samples\n{samples.T}\ndiffer; expected about\n{expected.T}")


async def wait_for_interrupt(machine: Machine, clocks: int) -> None:
    for _ in range(clocks):
        if int(machine.dut.interrupt.value):
            return
        await RisingEdge(machine.dut.clock)
    raise AssertionError(f"no interrupt within {clocks} clocks")


@cocotb.test()
async def from_edges_to_corrected_edges(dut):
    """The core captures the readings of the pins, which are read over AXI, gets coefficients over
    AXI, and outputs corrected edges."""
    machine = await prepared(dut, stall=0.2, seed=1)
    names = machine.registers
    await clear_coefficients(machine)
    assert (await names.check_identity())["lanes"] == LANES
    await names.update("control", output_enable=1, capture_enable=1, compensate=1)
    await names.update("interrupt_enable", capture_ready=1)

    turning = cocotb.start_soon(machine.turn(table.motion(5.8, CLOCKS_PER_COUNT)))
    banks = []
    for _ in range(2):
        await wait_for_interrupt(machine, 8000)
        capture = await names.read_capture()
        await names.command("capture_release")
        await names.clear_interrupts("capture_ready")
        banks.append(capture)
    assert [bank.sequence_number for bank in banks] == [0, 1]
    assert not any(bank.flags["overrun"] or bank.flags["full_before_turn"] for bank in banks)
    for bank in banks:
        check_samples(machine, bank.start_time, bank.samples)
        travelled = abs(bank.samples[:, 0] - bank.samples[0, 0])
        assert travelled[-1] >= table.COUNTS_PER_REV > travelled[-2]

    found = table.harmonics_from_capture(np.concatenate([bank.samples for bank in banks]))
    coefficients = Coefficients.from_harmonics(
        *zip(*found, strict=True), counts_per_rev=table.COUNTS_PER_REV, lanes=LANES
    )
    swapped_at = len(machine.angle)
    await names.write_coefficients(coefficients)
    before = await names.read("swap_count")
    await names.command("swap")
    settled_at = len(machine.angle) + 400
    await turning
    assert await names.read("swap_count") == before + 1
    status = await names.read_fields("status")
    assert status["compensating"] == 1
    assert status["ramp_busy"] == 0

    # After the ramp the corrected position equals the model's bit by bit, 29 clocks after the
    # decoder's position. A folded core outputs the correction of the position that it accepted
    # last, 28 + FOLD clocks after this position.
    reading = np.array(machine.reading)[:, 0]
    model = compensate(reading % table.COUNTS_PER_REV, reading, coefficients, rotation=ROTATION)
    corrected = np.array(machine.corrected)[settled_at:]
    matches = []
    for delay in range(28 + FOLD, 28 + FOLD + 12):
        for slot in range(FOLD):
            clock = np.arange(settled_at - delay, len(reading) - delay)
            expected = model.corrected_position[clock - (clock - slot) % FOLD]
            difference = corrected - expected
            if np.all(difference == difference[0]):
                matches.append(delay)
    assert len(matches) == 1, f"equal to the model at delays {matches}"
    dut._log.info("pins to corrected position: %d clocks", matches[0])

    # The error of the output is its difference to the table's true angle minus the mean of this
    # difference (a0), which is arbitrary.
    angle, output = np.array(machine.angle), np.array(machine.output)
    late = 6 + matches[0]
    turn_clocks = int(table.COUNTS_PER_REV * CLOCKS_PER_COUNT)

    def error(first: int) -> NDArray[np.float64]:
        deviation = (
            output[first : first + turn_clocks] - angle[first - late : first - late + turn_clocks]
        )
        return deviation - deviation.mean()

    uncorrected = error(swapped_at - turn_clocks)
    left = error(len(output) - turn_clocks)
    dut._log.info(
        "peak error %.2f counts before, %.2f after", abs(uncorrected).max(), abs(left).max()
    )
    assert abs(uncorrected).max() > 6
    assert abs(left).max() < 2
    assert (await names.read_fields("status"))["cannot_keep_up"] == 0


@cocotb.test()
async def capture_under_stalls_loses_nothing(dut):
    """A slow processor with stalls on the bus reads only complete turns, and every turn that it
    misses is counted."""
    machine = await prepared(dut, stall=0.5, seed=2)
    names = machine.registers
    await names.update("control", capture_enable=1)
    turning = cocotb.start_soon(machine.turn(table.motion(5.3, CLOCKS_PER_COUNT)))
    generator = random.Random(3)
    numbers = []
    while not turning.done():
        await ClockCycles(dut.clock, generator.choice([10, 100, 3000]))
        if await names.read("status.capture_ready"):
            capture = await names.read_capture()
            again = await names.read_capture()
            assert np.array_equal(capture.samples, again.samples), (
                "a bank changed while it was read"
            )
            check_samples(machine, capture.start_time, capture.samples)
            numbers.append(capture.sequence_number)
            await names.command("capture_release")
    dropped = await names.read("overrun_count")
    dut._log.info("turns read: %s, dropped: %d", numbers, dropped)
    assert len(numbers) >= 3
    assert numbers == sorted(set(numbers))
    assert numbers[-1] + 1 - len(numbers) <= dropped


@cocotb.test()
async def a_scattered_index_changes_no_capture(dut):
    """If the places of the index marks scatter by ±1 count, every capture is complete and no fault
    is reported."""
    machine = await prepared(dut)
    names = machine.registers
    assert await names.read("index_tolerance") == 2
    machine.index_scatter = (0, 1, -1, 0, -1, 1)  # places of successive marks differ by up to 2
    await names.update("control", capture_enable=1)
    turning = cocotb.start_soon(machine.turn(table.motion(6.0, CLOCKS_PER_COUNT)))
    lengths = []
    while not turning.done():
        await ClockCycles(dut.clock, 100)
        if await names.read("status.capture_ready"):
            capture = await names.read_capture()
            await names.command("capture_release")
            check_samples(machine, capture.start_time, capture.samples)
            travelled = abs(capture.samples[:, 0] - capture.samples[0, 0])
            assert travelled[-1] >= table.COUNTS_PER_REV > travelled[-2]
            assert not any(
                value for name, value in capture.flags.items() if "index_seen" not in name
            )
            lengths.append(len(capture.samples))
    assert len(lengths) >= 4
    assert max(lengths) - min(lengths) <= 1, "captures at one speed differ in length"
    for head in ("head1", "head2"):
        assert await names.read(f"{head}.faults.index_errors") == 0
        fields = await names.read_fields(f"{head}.index")
        assert 0 < abs(fields["interval"] - table.COUNTS_PER_REV) <= 2
    # With a tolerance of 1 and the same marks, the core reports a difference of 2 counts as an
    # index error.
    await names.write("index_tolerance", 1)
    end = table.motion(6.0, CLOCKS_PER_COUNT).size
    await machine.turn(table.motion(9.0, CLOCKS_PER_COUNT)[end:])
    for head in ("head1", "head2"):
        assert await names.read(f"{head}.faults.index_errors") == 1
        assert await names.read(f"{head}.flags.index_error") == 1
    snapshot = await names.snapshot()
    assert (snapshot.head1_turn_position, snapshot.head2_turn_position) == machine.reading[-1]


@cocotb.test()
async def correction_waits_for_the_index(dut):
    """Although coefficients are active and `compensate` is set, the position is not corrected
    before the index."""
    machine = await prepared(dut)
    names = machine.registers
    coefficients = Coefficients.from_harmonics(
        [1], [6.0], [0.0], table.COUNTS_PER_REV, LANES, offset_counts=20.0
    )
    await names.write_coefficients(coefficients)
    await names.command("swap")
    await names.update("control", compensate=1, output_enable=1)
    await machine.turn(table.motion(0.1, CLOCKS_PER_COUNT))
    assert not await names.read("status.compensating")
    assert set(np.diff(machine.corrected)) <= {0, 1}, "corrected before the index"
    assert (await names.snapshot()).correction == 0
    first_part = table.motion(0.1, CLOCKS_PER_COUNT).size
    await machine.turn(table.motion(0.5, CLOCKS_PER_COUNT)[first_part:])
    assert await names.read("status.compensating")
    await ClockCycles(dut.clock, 400)
    snapshot = await names.snapshot()
    assert snapshot.head1_position - snapshot.corrected_position == round(
        snapshot.correction / 2048
    )
    assert 14 * 2048 <= snapshot.correction <= 26 * 2048
    # The core's correction differs from ε(R) in float64 by at most 2^-12 count because of the
    # rounded amplitude, 2^-11 because of the truncation, and 6 counts times 5.6e-5 because of the
    # cosine's error.
    exact = snapshot.head1_position - coefficients.error_counts(np.array([snapshot.head1_angle]))
    assert abs(snapshot.exact_position_counts - exact[0]) < 2**-12 + 2**-11 + 6 * 5.6e-5
    # The output has lost no count at the index and at the start of the correction, because at first
    # its levels were those of head 1 at the same count.
    corrected = machine.corrected
    to_phase = machine.output[-1] - machine.output[0] - (corrected[-1] - corrected[0])
    assert abs(to_phase) <= 2
    place = corrected[-1] - snapshot.head1_position + machine.reading[-1][0]
    assert (machine.output[-1] - place) % 4 == 0
    # A count of the head and a count of the ramp may fall into one clock, so 2 counts are
    # permitted; without the ramp the output would step by at least 14.
    assert np.abs(np.diff(corrected)).max() <= 2, "the corrected position made a step"
    # When `compensate` is off, the ramp removes the correction, and the output returns to head 1's
    # position.
    await names.update("control", compensate=0)
    await ClockCycles(dut.clock, 400)
    snapshot = await names.snapshot()
    assert (snapshot.correction, snapshot.corrected_position) == (0, snapshot.head1_position)
    await clear_coefficients(machine)


@cocotb.test()
async def z_waits_for_the_index(dut):
    """Z does not rise before the first index or between a re-arm and the next index; all other
    pulses of Z are a turn apart."""
    machine = await prepared(dut)
    names = machine.registers
    await names.update("control", output_enable=1)
    motion = table.motion(3.4, CLOCKS_PER_COUNT)
    of_head1 = table.readings(motion)[:, 0]
    # The table passes the index at reading 0; the output follows within 60 clocks.
    first_index = int(np.argmax(of_head1 >= 0))
    begun = len(machine.z)
    turning = cocotb.start_soon(machine.turn(motion))
    await ClockCycles(dut.clock, first_index + int(table.COUNTS_PER_REV * CLOCKS_PER_COUNT * 1.5))
    rearmed = len(machine.z) - begun
    await names.command("rearm")
    await turning
    z = np.array(machine.z[begun:])
    output = np.array(machine.output[begun:])
    rises = np.flatnonzero(np.diff(z) == 1)
    second = int(np.argmax(of_head1 >= 2 * table.COUNTS_PER_REV))
    assert rearmed < second, "the re-arm comes before the second index"
    assert not z[: first_index - 1].any(), "Z before the first index"
    assert not z[rearmed + 60 : second - 1].any(), "Z between the re-arm and the next index"
    assert [(output[at + 1] - output[rises[0] + 1]) for at in rises] == [
        0,
        table.COUNTS_PER_REV,
        2 * table.COUNTS_PER_REV,
        3 * table.COUNTS_PER_REV,
    ][: len(rises)]
    assert len(rises) == 4


@cocotb.test()
async def turn_length_and_rearm(dut):
    machine = await prepared(dut)
    names = machine.registers
    assert await names.read("counts_per_rev_active") == table.COUNTS_PER_REV
    for illegal in (0, 3, (1 << 24) + 1, (1 << 25) - 1, 0x0200_1000, (1 << 31) + 600):
        await names.write("counts_per_rev", illegal)
        await names.command("rearm")
        await ClockCycles(dut.clock, 200)
        assert await names.read("status.counts_per_rev_refused") == 1
        assert await names.read("counts_per_rev_active") == table.COUNTS_PER_REV
    for legal in (4, 5, 1 << 24, 600):
        await names.write("counts_per_rev", legal)
        assert await names.read("counts_per_rev_active") != legal
        await names.command("rearm")
        await ClockCycles(dut.clock, 200)
        assert await names.read("status.counts_per_rev_refused") == 0
        assert await names.read("counts_per_rev_active") == legal
    motion = table.motion(0.5, CLOCKS_PER_COUNT)
    await machine.turn(motion)
    await ClockCycles(dut.clock, 20)
    for head in ("head1", "head2"):
        assert await names.read(f"{head}.flags.index_seen") == 1
    snapshot = await names.snapshot()
    last = machine.reading[-1]
    assert (snapshot.head1_turn_position, snapshot.head2_turn_position) == last
    assert (snapshot.head1_angle, snapshot.head2_angle) == last
    await names.command("rearm")
    await ClockCycles(dut.clock, 200)
    for head in ("head1", "head2"):
        assert await names.read(f"{head}.flags.index_seen") == 0
    after = await names.snapshot()
    assert (after.head1_angle, after.head2_angle) == (0, 0)
    assert after.head1_position == snapshot.head1_position


@cocotb.test()
async def a_shorter_turn_sends_no_burst(dut):
    """A new, shorter turn limits the correction at once; the output does not follow this step."""
    machine = await prepared(dut)
    names = machine.registers
    coefficients = Coefficients.from_harmonics(
        [], [], [], table.COUNTS_PER_REV, LANES, offset_counts=120.0
    )
    await names.write_coefficients(coefficients)
    await names.command("swap")
    await names.update("control", compensate=1, output_enable=1)
    await machine.turn(table.motion(0.5, CLOCKS_PER_COUNT))
    await ClockCycles(dut.clock, 2000)
    assert (await names.snapshot()).correction == 120 * 2048
    # With a rate of 0 the ramp does not change the correction, so only the limit of 31 counts
    # changes it.
    await names.write("ramp_rate", 0)
    before = machine.output[-1]
    await names.write("counts_per_rev", 64)
    await names.command("rearm")
    await ClockCycles(dut.clock, 1500)
    assert (await names.snapshot()).correction == 31 * 2048
    assert abs(machine.output[-1] - before) <= 2, "more than the edges to the new levels"
    assert not await names.read("status.cannot_keep_up")
    await names.write("ramp_rate", FASTEST_RAMP)
    await clear_coefficients(machine)


@cocotb.test()
@cocotb.parametrize((("heal", "head2_dead"), LOSSES))
async def lost_counts_leave_the_correction_on(dut, heal: int, head2_dead: bool):
    """After head 1's wires lose a period (four counts), the correction stays on, and the angle and
    Z become right again.

    The core recognises the loss at the first mark if head 2 works, otherwise at the second mark. If
    it puts the counts back, the output's count equals the table's again.
    """
    machine = await prepared(dut)
    names = machine.registers
    await names.write_coefficients(
        Coefficients.from_harmonics([1], [6.0], [0.4], table.COUNTS_PER_REV, LANES)
    )
    await names.command("swap")
    await names.update("control", compensate=1, output_enable=1)
    await names.update("lost_counts", zero_again=1, heal=heal)
    motion = table.motion(4.7, CLOCKS_PER_COUNT)
    lost_at = int(np.argmax(table.readings(motion)[:, 0] >= table.COUNTS_PER_REV + 50))
    await machine.turn(motion[:lost_at])
    assert await names.read("status.compensating")
    machine.stuck_at = table.COUNTS_PER_REV + 50
    machine.head2_stands = head2_dead
    seen = []

    async def watch() -> None:
        while True:
            await FallingEdge(dut.clock)
            seen.append(int(dut.status_compensating.value))

    cocotb.start_soon(watch())
    marks = 2 if head2_dead else 1
    proven_at = int(np.argmax(table.readings(motion)[:, 0] >= (1 + marks) * table.COUNTS_PER_REV))
    await machine.turn(motion[lost_at : proven_at - 100])
    assert await names.read("zero.moves") == 0
    await machine.turn(motion[proven_at - 100 : proven_at + 200])
    assert await names.read("zero.moves") == 1
    assert await names.read("head1.faults.index_errors") == marks
    await machine.turn(motion[proven_at + 200 :])
    await ClockCycles(dut.clock, 100)
    assert (await names.read("zero.moves"), await names.read("zero_slip")) == (1, -4)
    assert await names.read("put_back") == 4 * heal
    assert all(seen), "the correction was switched off"
    assert await names.read("head1.flags.index_error") == 1
    snapshot = await names.snapshot()
    reading = machine.reading[-1][0]
    assert snapshot.head1_angle == reading % table.COUNTS_PER_REV
    assert snapshot.head1_turn_position % table.COUNTS_PER_REV == snapshot.head1_angle
    rises = np.flatnonzero(np.diff(machine.z) == 1)
    at_z = np.array(machine.output)[rises + 1]
    # Unless the core puts the four lost counts back, the distance between pulses of Z before and
    # after the loss is four counts too small, because the output lacks these counts too.
    assert at_z[1] - at_z[0] == table.COUNTS_PER_REV
    assert at_z[-1] - at_z[0] == 4 * table.COUNTS_PER_REV - 4 * (1 - heal)
    assert np.abs(np.diff(machine.corrected)).max() <= 2
    await clear_coefficients(machine)


@cocotb.test()
async def samples_at_equal_angles_lie_on_the_grid_of_a_zero_that_moved(dut):
    """Head 1 loses four counts, and the core moves the zero of head 1 by these counts; in the next
    turn the samples lie on multiples of the angle step again."""
    step = 32
    machine = await prepared(dut)
    names = machine.registers
    await names.write("angle_step", step)
    await names.update("control", capture_enable=1, capture_mode=1)
    await names.update("lost_counts", zero_again=1, heal=0)
    motion = table.motion(5.7, CLOCKS_PER_COUNT)
    reading = table.readings(motion)[:, 0]
    machine.stuck_at = table.COUNTS_PER_REV + 50
    moved = int(np.argmax(reading >= 2 * table.COUNTS_PER_REV)) + 100
    await machine.turn(motion[:moved])
    assert (await names.read("zero.moves"), await names.read("zero_slip")) == (1, -4)
    captures = []
    for first in range(moved, len(motion), 500):
        await machine.turn(motion[first : first + 500])
        if await names.read("status.capture_ready"):
            captures.append((await names.read_capture()).samples[:, 0])
            await names.command("capture_release")
    # The first capture ends before the zero moves; during the second capture it moves.
    samples = captures[-1]
    assert samples.size > table.COUNTS_PER_REV // step
    assert not np.any(samples % step), samples


@cocotb.test()
async def a_mark_out_of_its_place_moves_nothing(dut):
    """If one mark comes 20 counts late and all later marks come in place, the core reports two
    index errors, for the late mark and for the next mark, and does not move the zero."""
    machine = await prepared(dut)
    names = machine.registers
    await names.update("control", compensate=1, output_enable=1)
    await names.update("lost_counts", zero_again=1, heal=1)
    machine.index_scatter = (0, 0, 20, 0, 0, 0)
    await machine.turn(table.motion(5.5, CLOCKS_PER_COUNT))
    assert await names.read("head1.faults.index_errors") == 2
    assert (await names.read("zero.moves"), await names.read("put_back")) == (0, 0)
    snapshot = await names.snapshot()
    assert snapshot.head1_angle == machine.reading[-1][0] % table.COUNTS_PER_REV
    assert np.abs(np.diff(machine.corrected)).max() <= 2


@cocotb.test()
@cocotb.parametrize(swaps=[0, 1])
async def polarity_and_direction_of_the_pins(dut, swaps: int):
    """The input settings undo an inverted A and, with ``swaps``, exchanged A and B; the output's
    settings invert and exchange its pins."""
    machine = await prepared(dut)
    names = machine.registers
    await names.update("head1_input.pins", invert_a=1, invert_z=1, swap_ab=swaps)
    await names.update("output_pins", invert_b=1, swap_ab=swaps)

    async def show(reading: int) -> None:
        a, b, z = (table.pins(reading) >> place & 1 for place in range(3))
        dut.head1_a.value, dut.head1_b.value = (1 - b, a) if swaps else (1 - a, b)
        dut.head1_z.value = 1 - z
        await ClockCycles(dut.clock, 10)

    await show(1)
    await names.command("rearm", "clear_head1", "clear_head2")
    await ClockCycles(dut.clock, 300)
    # When the output is enabled, its levels become those of head 1.
    await names.update("control", output_enable=1)
    before = await names.snapshot()
    for reading in range(1, 42):
        await show(reading)
    await ClockCycles(dut.clock, 100)
    after = await names.snapshot()
    assert after.head1_position - before.head1_position == 40
    assert await names.read("head1.flags.index_seen") == 0
    assert await names.read("head1.flags.illegal") == 0
    first, second = int(dut.out_a.value), int(dut.out_b.value)
    # Apart from its inversion and exchange, the output has the levels of the encoder at the same
    # count.
    assert ((1 - second, first) if swaps else (first, 1 - second)) == (
        table.pins(41) & 1,
        table.pins(41) >> 1 & 1,
    )
    await names.update("head1_input.pins", invert_a=0, invert_z=0, swap_ab=0)
    await names.update("output_pins", invert_b=0, swap_ab=0)


@cocotb.test()
async def alarm_and_release_of_the_drivers(dut):
    machine = await prepared(dut)
    names = machine.registers
    await names.command("clear_head1", "clear_head2")
    await names.update("control", output_enable=1)
    await names.update("alarm", sources=0b00010, released_by=0b00010)
    await ClockCycles(dut.clock, 4)
    assert (int(dut.alarm.value), int(dut.driver_enable.value)) == (0, 1)
    dut.head2_a.value, dut.head2_b.value = 1 - int(dut.head2_a.value), 1 - int(dut.head2_b.value)
    await ClockCycles(dut.clock, 20)
    assert (int(dut.alarm.value), int(dut.driver_enable.value)) == (1, 0)
    await names.command("clear_head2")
    await ClockCycles(dut.clock, 4)
    assert (int(dut.alarm.value), int(dut.driver_enable.value)) == (0, 0), (
        "the drivers were enabled without clear_output"
    )
    assert await names.read("status.released") == 1
    await names.command("clear_output")
    await ClockCycles(dut.clock, 4)
    assert int(dut.driver_enable.value) == 1
    assert await names.read("status.released") == 0
    assert machine.output[-1] == machine.output[0]


@cocotb.test()
async def one_clear_brings_an_output_back_that_could_not_keep_up(dut):
    """The write that clears `cannot_keep_up` also ends the release of the drivers by this flag, but
    not a release by a head's flag."""
    machine = await prepared(dut)
    names = machine.registers
    await names.command("clear_head1", "clear_head2")
    await names.write("output_spacing", 1000)
    await names.write("following_limit", 5)
    await names.update("alarm", sources=0, released_by=0b00100)
    await names.update("control", output_enable=1)
    await ClockCycles(dut.clock, 8)
    assert int(dut.driver_enable.value) == 1
    await machine.turn(table.motion(0.1, CLOCKS_PER_COUNT))
    await ClockCycles(dut.clock, 20)
    assert int(dut.driver_enable.value) == 0
    status = await names.read_fields("status")
    assert (status["cannot_keep_up"], status["released"]) == (1, 1)
    assert (status["release_causes"], status["release_present"]) == (0b00100, 0b00100)
    await names.update("alarm", released_by=0b00101)
    dut.head1_a.value, dut.head1_b.value = 1 - int(dut.head1_a.value), 1 - int(dut.head1_b.value)
    await ClockCycles(dut.clock, 20)
    await names.command("clear_output")
    await ClockCycles(dut.clock, 4)
    status = await names.read_fields("status")
    assert (status["cannot_keep_up"], status["released"]) == (0, 1), (
        "the flag of head 1 did not keep the release"
    )
    assert (status["release_causes"], status["release_present"]) == (0b00001, 0b00001)
    assert int(dut.driver_enable.value) == 0
    await names.command("clear_output", "clear_head1")
    await ClockCycles(dut.clock, 4)
    assert int(dut.driver_enable.value) == 1
    status = await names.read_fields("status")
    assert not status["released"]
    assert (status["release_causes"], status["release_present"]) == (0, 0)


@cocotb.test()
@cocotb.parametrize(releases=[0, 1])
async def edges_that_the_filter_swallows_are_a_fault_at_the_output_where_asked_for(dut, releases):
    """If the filter suppresses all edges while the table turns, the output stands still; the core
    raises an alarm and, with ``releases``, releases the drivers."""
    machine = await prepared(dut)
    names = machine.registers
    await names.write("filter_length", 12)
    await ClockCycles(dut.clock, 40)
    await names.command("clear_head1", "clear_head2")
    swallowed = 0b100000
    await names.update("alarm", sources=swallowed, released_by=releases * swallowed)
    await names.update("control", output_enable=1)
    slow = table.motion(0.05, 4 * CLOCKS_PER_COUNT)
    await machine.turn(slow)
    assert (int(dut.alarm.value), int(dut.driver_enable.value)) == (0, 1)
    before = machine.output[-1]
    fast = slow[-1] + np.arange(60 * CLOCKS_PER_COUNT) / CLOCKS_PER_COUNT
    await machine.turn(fast)
    assert abs(machine.output[-1] - before) <= 4, "the filter passed edges"
    assert (int(dut.alarm.value), int(dut.driver_enable.value)) == (1, 1 - releases)
    assert await names.read("head1.flags.swallowed") == 1
    assert await names.read("status.release_causes") == releases * swallowed
    await ClockCycles(dut.clock, 40)
    await names.command("clear_head1", "clear_output")
    await ClockCycles(dut.clock, 4)
    assert (int(dut.alarm.value), int(dut.driver_enable.value)) == (0, 1)
    assert await names.read("head1.flags.swallowed") == 0
    # Edges that the filter passes, but that are too close to each other, set another flag.
    await names.write("filter_length", 1)
    await names.write("minimum_edge_spacing", 50)
    await machine.turn(fast[-1] + np.arange(60 * CLOCKS_PER_COUNT) / CLOCKS_PER_COUNT)
    assert await names.read("head1.flags.overspeed") == 1
    assert (int(dut.alarm.value), int(dut.driver_enable.value)) == (0, 1)


@cocotb.test()
async def a_reset_of_the_core_does_not_drop_the_line_drivers(dut):
    """After a reset of the core, `driver_enable` stays high until the processor has set up the
    output again."""
    machine = await prepared(dut)
    names = machine.registers
    await names.update("control", output_enable=1)
    await ClockCycles(dut.clock, 8)
    driven = []

    async def watch() -> None:
        while True:
            await FallingEdge(dut.clock)
            driven.append(int(dut.driver_enable.value))

    cocotb.start_soon(watch())
    await FallingEdge(dut.clock)
    dut.reset.value = 1
    await FallingEdge(dut.clock)
    dut.reset.value = 0
    await ClockCycles(dut.clock, 300)
    assert await names.read("control.output_enable") == 0
    await names.update("control", output_enable=1)
    await ClockCycles(dut.clock, 8)
    await names.update("control", output_enable=0)
    await ClockCycles(dut.clock, 8)
    assert all(driven[:300])
    assert not driven[-1], "driver_enable did not follow output_enable after the hold"


@cocotb.test()
async def external_instruments(dut):
    """An edge of sync_in requests a sample, each sample gives a pulse of trigger_out, an edge of
    probe_in latches the position, and compare_out has a pulse every 64 counts."""
    machine = await prepared(dut)
    names = machine.registers
    await names.update("control", capture_enable=1, capture_mode=2, output_enable=1)
    await names.update("pulse_widths", trigger=5, compare=3)
    probed, pulses, compared = [], [], []

    async def watch() -> None:
        while True:
            await FallingEdge(dut.clock)
            pulses.append(int(dut.trigger_out.value))
            compared.append(int(dut.compare_out.value))

    cocotb.start_soon(watch())
    zero = readings_at(table.START_COUNTS)[0]
    motion = table.motion(2.4, CLOCKS_PER_COUNT)
    begin = int(np.argmax(table.readings(motion)[:, 0] >= 20))
    await machine.turn(motion[:begin])
    await names.write("compare.first", machine.reading[-1][0] - zero + 100)
    await names.write("compare.interval", 64)
    await names.command("compare_arm")
    asked = 0
    for first in range(begin, len(motion), 50):
        dut.sync_in.value = 1
        dut.probe_in.value = 1
        probed.append(machine.pair[0])
        asked += 1
        await machine.turn(motion[first : first + 25])
        dut.sync_in.value = 0
        dut.probe_in.value = 0
        await machine.turn(motion[first + 25 : first + 50])
    await ClockCycles(dut.clock, 100)
    # The read of the low word latches the other words of its group.
    assert await names.read("probe.time") > machine.first_time
    assert await names.read("probe.edges") == asked % 2**16
    rises = np.flatnonzero(np.diff(pulses) == 1)
    assert rises.size == asked
    falls = np.flatnonzero(np.diff(pulses) == -1)
    assert np.all(falls - rises == 5)
    capture = await names.read_capture()
    apart = np.diff(capture.samples[:, 0])
    assert np.all(np.abs(apart - 50 / CLOCKS_PER_COUNT) <= 4)
    place = np.flatnonzero(np.diff(compared) == 1)
    at = np.array(machine.corrected)[-len(compared) :][place]
    assert place.size > 3
    assert np.all(np.diff(at) == 64)
    # Without a correction the latched position is the number of counts on the pins from the reset
    # to the probe's edge.
    latched = await names.read("probe.position")
    assert abs(latched + zero - probed[-1]) <= 1


async def waiting_events(names: RegisterMap) -> NDArray[np.int64]:
    """Take all events from the queue; return kind, number, time, position and angle of each."""
    rows = []
    while (state := await names.read_fields("events.state"))["kind"]:
        low, high = [await names.read(f"events.time_{half}") for half in ("low", "high")]
        place = [await names.read(f"events.{name}") for name in ("position", "angle")]
        rows.append((state["kind"], state["sequence_number"], high << 32 | low, *place))
        await names.command("next_event")
    return np.array(rows, dtype=np.int64).reshape(-1, 5)


@cocotb.test(skip=not EVENTS)
async def events_wait_for_the_processor(dut):
    """If compare_out is connected to probe_in, each compare pulse and the edge that it causes form
    one event of both kinds, with the right time."""
    machine = await prepared(dut)
    names = machine.registers
    assert await names.read("events.recorded.compare") == 0
    await names.update("control", output_enable=1)
    await names.update("pulse_widths", compare=1)
    await names.update("events.recorded", probe=1, compare=1)
    compared = []

    async def wire() -> None:
        while True:
            await FallingEdge(dut.clock)
            compared.append(int(dut.compare_out.value))
            dut.probe_in.value = dut.compare_out.value

    cocotb.start_soon(wire())
    begin = len(machine.reading)
    zero = readings_at(table.START_COUNTS)[0]
    motion = table.motion(5.8, CLOCKS_PER_COUNT)
    interval = 16
    await names.write("compare.first", machine.reading[-1][0] - zero + 50)
    await names.write("compare.interval", interval)
    await names.command("compare_arm")
    await machine.turn(motion[: 60 * interval * int(CLOCKS_PER_COUNT)])
    await ClockCycles(dut.clock, 100)
    early = len(compared)
    found = await waiting_events(names)
    rises = np.flatnonzero(np.diff(compared[:early]) == 1) + 1
    assert 20 < rises.size < 64
    assert np.all(found[:, 0] == 3), "a compare pulse and its edge are not one event"
    assert np.array_equal(found[:, 1], np.arange(rises.size))
    assert np.array_equal(np.diff(found[:, 2]), np.diff(rises))
    reading = np.array(machine.reading)[begin:, 0][rises]
    assert np.abs(found[:, 3] + zero - reading).max() <= 1
    assert await names.read("events.lost") == 0
    # The latch holds the values of the last event.
    await names.read("probe.time")
    assert await names.read("probe.position") == found[-1, 3]
    assert await names.read("probe.edges") == rises.size
    # If more events come than the queue can hold, the first events stay in it, and `events.lost`
    # counts the others.
    await machine.turn(motion[60 * interval * int(CLOCKS_PER_COUNT) :])
    await ClockCycles(dut.clock, 100)
    more = int(np.count_nonzero(np.diff(compared) == 1)) - rises.size
    assert more > 70
    assert await names.read("events.state.waiting") == 64
    assert await names.read("events.lost") == more - 64
    late = await waiting_events(names)
    assert np.array_equal(late[:, 1], rises.size + np.arange(64))
    # From now on only edges of the probe are recorded.
    await names.update("events.recorded", probe=1, compare=0)
    await names.command("compare_disarm")
    dut.probe_in.value = 1
    await ClockCycles(dut.clock, 100)
    assert (await waiting_events(names)).size == 0, (
        "an event although compare_out holds probe_in low"
    )


@cocotb.test()
async def faults_reach_the_processor(dut):
    machine = await prepared(dut)
    names = machine.registers
    await names.clear_interrupts()
    await names.update("interrupt_enable", head2_fault=1)
    levels = [int(dut.head2_a.value), int(dut.head2_b.value)]
    for _ in range(3):
        levels = [1 - level for level in levels]
        dut.head2_a.value, dut.head2_b.value = levels
        await ClockCycles(dut.clock, 20)
    assert int(dut.interrupt.value) == 1
    assert await names.read("interrupt_status.head2_fault") == 1
    assert await names.read("interrupt_status.head1_fault") == 0
    assert await names.read("head2.faults.illegals") == 3
    assert await names.read("head2.flags.illegal") == 1
    await names.clear_interrupts("head2_fault")
    await ClockCycles(dut.clock, 5)
    assert int(dut.interrupt.value) == 0
    await names.command("clear_head1")
    assert await names.read("head2.faults.illegals") == 3
    await names.command("clear_head2")
    assert await names.read("head2.faults.illegals") == 0
    assert await names.read("head2.flags.illegal") == 0


@cocotb.test()
async def illegal_accesses_are_refused(dut):
    machine = await prepared(dut)
    bus = machine.bus
    last_word = registers.COEFFICIENTS_ADDRESS + 16 * LANES - 4
    assert await bus.write(last_word, 0xFFFFF801) == AxiResp.OKAY
    assert await bus.read(last_word) == (AxiResp.OKAY, 0xFFFFF801)
    assert await bus.write(last_word, 0x55, 0b0001) == AxiResp.SLVERR
    assert await bus.read(last_word) == (AxiResp.OKAY, 0xFFFFF801)
    for address in (last_word + 4, registers.COEFFICIENTS_ADDRESS + 4 * 255, 0x7FC, 0x10000):
        assert await bus.write(address, 1) == AxiResp.SLVERR
        assert await bus.read(address) == (AxiResp.SLVERR, 0)
    assert await bus.read(registers.CAPTURE_ADDRESS) == (AxiResp.SLVERR, 0), "no bank is ready"
    assert await bus.write(registers.VERSION_ADDRESS, 0) == AxiResp.SLVERR
    assert (await bus.read(registers.COMMAND_ADDRESS))[0] == AxiResp.SLVERR
    await machine.registers.write("coefficient_offset", -3)
    assert await machine.registers.read("coefficient_offset") == -3
    identity = await machine.registers.check_identity()
    assert identity == {
        "lanes": LANES,
        "cosine_width": number_formats.COSINE_WIDTH,
        "capture_depth": CAPTURE_DEPTH,
    }
    pipeline = await machine.registers.read_fields("pipeline")
    assert pipeline == {"fold": FOLD, "latency": 28 + FOLD}
    capability = await machine.registers.read_fields("capability")
    assert capability == {
        "heads": 2,
        "mean": 0,
        "rotation": int(ROTATION == "table"),
        "modulators": 0,
        "real_orders": 0,
        "local_table": 0,
        "failover": 0,
        "events": int(EVENTS),
    }
    first = (await machine.registers.snapshot()).time
    second = (await machine.registers.snapshot()).time
    assert 0 < second - first < 1000
    await machine.registers.write_coefficients(Coefficients.zero(table.COUNTS_PER_REV, LANES))


@cocotb.test()
async def interrupt_of_a_swap_and_its_ramp(dut):
    machine = await prepared(dut)
    names = machine.registers
    await clear_coefficients(machine)
    await machine.turn(table.motion(0.5, CLOCKS_PER_COUNT))
    await names.update("control", compensate=1)
    await ClockCycles(dut.clock, 100)
    await names.clear_interrupts()
    await names.write_coefficients(
        Coefficients.from_harmonics([], [], [], table.COUNTS_PER_REV, LANES, offset_counts=8.0)
    )
    await names.command("swap")
    await ClockCycles(dut.clock, 40)
    assert await names.read("interrupt_status.swap_done") == 1
    assert await names.read("status.ramp_busy") == 1
    await ClockCycles(dut.clock, 200)  # 8 counts at 1/8 count per clock: 64 clocks
    assert await names.read("interrupt_status.ramp_done") == 1
    assert await names.read("status.ramp_busy") == 0
    assert (await names.snapshot()).correction == 8 * 2048
    await clear_coefficients(machine)
