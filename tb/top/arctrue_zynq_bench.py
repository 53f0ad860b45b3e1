"""Tests the device's top level in cocotb: the processor's AXI3 port, the encoder pins, and the
LEDs.

A model replaces the primitive PS7. The core has tests of its own.
"""

from __future__ import annotations

import itertools
import os
from typing import Any

import cocotb
import numpy as np
import pytest
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, FallingEdge, ReadOnly, RisingEdge, Timer
from numpy.typing import NDArray

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.register_access import RegisterMap
from arctrue.generated import registers
from tb.core import arctrue_core_table as table
from tb.top.axi3_master import OKAY, Axi3Master, BusError

LANES = 2
CAPTURE_DEPTH = 64
LED_HOLD_LOG2 = 5
WINDOW = 2**LED_HOLD_LOG2

BASE = 0x4000_0000
SLVERR, DECERR = 2, 3
CLOCK_NS = 10
SAMPLE_PERIOD = 50
CLOCKS_PER_COUNT = 5.0
FASTEST_RAMP = 0xFFFF_FFFF
PIPELINE_CLOCKS = 100  # clocks; above the latency from pin to pin, 5 + 29 + 6
RESET_CLOCKS = 64  # minimum duration of the core's reset
# Largest number of clocks from the end of the processor's reset to the end of the core's reset:
# RESET_CLOCKS, 3 clocks of reset_release, and one if its first register samples the edge late.
RESET_RELEASE_CLOCKS = RESET_CLOCKS + 4

DNA = 0x1_23456789_ABCDEF  # identifier in the model dna_port.vhd
DNA_CLOCKS = 118 * 8  # the latency of chip_dna, 116 * 8, and a margin of 2 * 8

HEAD_PINS = ("head1_a", "head1_b", "head1_z", "head2_a", "head2_b", "head2_z")
LEDS = ("led_alive", "led_capture", "led_fault", "led_compensation")
PAIRS = os.environ.get("ARCTRUE_PAIRS") == "1"
"""Whether the encoder pins are differential pairs, as in arctrue_zynq_differential_top."""
FOLD = int(os.environ.get("ARCTRUE_FOLD", "1"))

OUTPUT_STEP = {(0, 0): 0, (1, 0): 1, (1, 1): 2, (0, 1): 3}


class Device:
    """Drives the top level with the readings of a turning table, and decodes its output signals."""

    def __init__(self, dut: Any) -> None:
        self.dut = dut
        self.top = dut.device.single_ended.device if PAIRS else dut.device.device
        self.ps7 = self.top.processor.ps7_primitive
        self.clock = self.ps7.fabric_clock
        self.axi = Axi3Master(self.ps7)
        self.registers = RegisterMap(self.axi.read_words, self.axi.write_words, base=BASE)
        self.position = 0

    def drive(self, name: str, level: int) -> None:
        if PAIRS:
            getattr(self.dut, f"{name}_p").value = level
            getattr(self.dut, f"{name}_n").value = 1 - level
        else:
            getattr(self.dut, name).value = level

    def level(self, name: str) -> int:
        if not PAIRS:
            return int(getattr(self.dut, name).value)
        level = int(getattr(self.dut, f"{name}_p").value)
        assert int(getattr(self.dut, f"{name}_n").value) == 1 - level, f"{name} is no pair"
        return level

    def lit(self) -> tuple[int, ...]:
        """Return the levels of the LEDs alive, capture, fault and compensation."""
        return tuple(int(getattr(self.dut, name).value) for name in LEDS)

    def show(self, reading1: int, reading2: int) -> None:
        levels = table.pins(reading1) | table.pins(reading2) << 3
        for place, name in enumerate(HEAD_PINS):
            self.drive(name, levels >> place & 1)

    async def turn(self, angle: NDArray[np.float64]) -> None:
        """Drive the readings for ``angle``, the table's angle in counts in each clock."""
        before = None
        for pair in table.readings(angle).tolist():
            if pair != before:
                self.show(*pair)
                before = pair
            await FallingEdge(self.clock)

    async def follow_the_output(self) -> None:
        """Count the edges of A and B of the output as a servo drive would, without end."""
        before = OUTPUT_STEP[self.level("out_a"), self.level("out_b")]
        while True:
            await FallingEdge(self.clock)
            now = OUTPUT_STEP[self.level("out_a"), self.level("out_b")]
            step = (now - before + 1) % 4 - 1
            assert step != 2, "the output changed A and B together"
            self.position += step
            before = now

    async def let_go(self) -> None:
        """End the processor's reset between two clock edges, and wait until the core's reset has
        ended."""
        await Timer(3, "ns")
        self.ps7.fabric_resetn.value = 1
        await ClockCycles(self.clock, RESET_RELEASE_CLOCKS)

    async def configure(self) -> None:
        names = self.registers
        await names.write("counts_per_rev", table.COUNTS_PER_REV)
        await names.command("rearm")
        await names.write("sample_period", SAMPLE_PERIOD)
        await names.write("ramp_rate", FASTEST_RAMP)
        await names.write("ramp_acceleration", 0)
        await names.write("output_spacing", 1)


async def started(dut: Any) -> Device:
    """Start the clock, hold the reset as at power-up, then end it; the table is at its start."""
    device = Device(dut)
    device.ps7.fabric_resetn.value = 0
    device.show(*table.readings(np.array([table.START_COUNTS]))[0].tolist())
    cocotb.start_soon(Clock(device.clock, CLOCK_NS, unit="ns", impl="gpi").start())
    await ClockCycles(device.clock, RESET_CLOCKS)
    await device.let_go()
    return device


@cocotb.test()
async def registers_over_axi3(dut: Any) -> None:
    """Bursts with IDs access the register map at the base address; other addresses are refused."""
    device = await started(dut)
    axi, names = device.axi, device.registers
    found = await names.check_identity()
    assert (found["lanes"], found["capture_depth"]) == (LANES, CAPTURE_DEPTH)
    assert await names.read("pipeline.fold") == FOLD
    # One burst writes words of the coefficient window, a second burst reads them back.
    words = [(n * 0x0101_0101 + 7) % 2**21 for n in range(4 * LANES)]
    assert await axi.write_burst(BASE + registers.COEFFICIENTS_ADDRESS, words) == OKAY
    read = await axi.read_burst(BASE + registers.COEFFICIENTS_ADDRESS, 4 * LANES)
    assert [answer for _, answer in read] == [OKAY] * len(words)
    # The memory does not store all bits of each word, so only words 0 and 2 of a lane, whose
    # written bits are all stored, are compared.
    assert [data for data, _ in read[0::4]] == words[0::4]
    assert [data for data, _ in read[2::4]] == words[2::4]
    # The bridge refuses an address outside its window.
    assert [answer for _, answer in await axi.read_burst(BASE + registers.MAP_BYTES, 1)] == [DECERR]
    assert await axi.write_burst(BASE + registers.MAP_BYTES, [0]) == DECERR
    # The core refuses the capture of heads 3 and 4, which it does not have.
    further = BASE + registers.FURTHER_CAPTURE_ADDRESS
    assert [answer for _, answer in await axi.read_burst(further, 1)] == [SLVERR]
    with pytest.raises(BusError, match=f"answer {SLVERR}"):
        await names.write_raw("identification", 0)


@cocotb.test()
async def from_edges_to_corrected_edges(dut: Any) -> None:
    """The output moves by as many counts as R - e(R) of equations (8) and (9), computed in
    float64."""
    device = await started(dut)
    names = device.registers
    await device.configure()
    order, amplitude, phase = 1, 9.0, 0.7
    await names.write_coefficients(
        Coefficients.from_harmonics([order], [amplitude], [phase], table.COUNTS_PER_REV, LANES)
    )
    await names.command("swap")
    await names.update("control", output_enable=1, compensate=1)
    cocotb.start_soon(device.follow_the_output())

    def expected(reading: int) -> float:
        turn = 2.0 * np.pi / table.COUNTS_PER_REV
        return reading - amplitude * np.cos(order * turn * reading + phase)

    motion = table.motion(1.6, CLOCKS_PER_COUNT)
    stops = [motion.size * part // 8 for part in range(3, 9)]  # the table has passed the index
    travelled, readings = [], []
    for first, last in zip([0, *stops], stops, strict=False):
        await device.turn(motion[first:last])
        await ClockCycles(device.clock, PIPELINE_CLOCKS)
        travelled.append(device.position)
        readings.append(int(table.readings(motion[last - 1 : last])[0, 0]))
    wanted = [expected(reading) - expected(readings[0]) for reading in readings]
    deviation = np.subtract(travelled, travelled[0]) - wanted
    dut._log.info("output less equation: %s counts", np.round(deviation, 2).tolist())
    # The bound is half a count for each of the two roundings (reading and output); the rounding
    # errors of the coefficients are far smaller.
    assert np.abs(deviation).max() <= 1.01
    plain = np.subtract(readings, readings[0]) - wanted
    assert np.abs(plain).max() > 8, "the motion does not show the correction"
    assert device.lit()[3] == 1


@cocotb.test()
async def interrupt_and_capture(dut: Any) -> None:
    """A captured turn raises only IRQF2P(0), its bank can be read over AXI3, and clearing the event
    ends the interrupt."""
    device = await started(dut)
    names = device.registers
    await device.configure()
    await names.clear_interrupts()
    await names.update("interrupt_enable", capture_ready=1)
    await names.update("control", capture_enable=1)
    assert int(device.ps7.irqf2p.value) == 0
    motion = table.motion(1.6, CLOCKS_PER_COUNT)
    turning = cocotb.start_soon(device.turn(motion))
    while not turning.done() and not int(device.ps7.irqf2p.value):
        await RisingEdge(device.clock)
    assert int(device.ps7.irqf2p.value) == 1, "no interrupt within 1.6 turns"
    capture = await names.read_capture()
    travelled = capture.samples[:, 0] - capture.samples[0, 0]
    assert travelled[-1] >= table.COUNTS_PER_REV > travelled[-2]
    # Both readings of a sample come from one clock, so each captured pair must be a pair that the
    # table has had.
    shown = set(map(tuple, table.readings(motion).tolist()))
    assert set(map(tuple, capture.samples.tolist())) <= shown
    await names.command("capture_release")
    await names.clear_interrupts("capture_ready")
    await ClockCycles(device.clock, 4)
    assert int(device.ps7.irqf2p.value) == 0
    await turning


@cocotb.test()
async def i2c_wires_are_open_drain(dut: Any) -> None:
    """The processor and the thermometer only pull a wire low; only the pull-up makes it high.

    While the processor outputs 1, the thermometer can pull the wire low without a conflict ('X').
    The two wires are independent, and the processor reads the level of each.
    """
    device = await started(dut)
    wires = ("scl", "sda")
    for states in itertools.product((0, 1), repeat=6):
        of_wire = dict(zip(wires, (states[:3], states[3:]), strict=True))
        for name, (value, drives, thermometer) in of_wire.items():
            getattr(device.ps7, f"{name}_value").value = value
            getattr(device.ps7, f"{name}_drives").value = drives
            getattr(dut, f"thermometer_{name}").value = thermometer
        await Timer(1, "ns")
        for name, (value, drives, thermometer) in of_wire.items():
            level = int(not (thermometer or (drives and not value)))
            assert str(getattr(dut, name).value) == str(level), (name, states)
            assert int(getattr(device.ps7, f"{name}_level").value) == level, (name, states)


@cocotb.test()
async def two_general_purpose_pins_are_on_the_i2c_wires(dut: Any) -> None:
    """Pin 54 pulls and reads SCL, pin 55 pulls and reads SDA; no other pin has an effect."""
    device = await started(dut)
    others = (1 << 64) - 4
    for name in ("scl", "sda"):
        getattr(device.ps7, f"{name}_drives").value = 0
    states = itertools.product(range(4), range(4), range(4), (0, 1))
    for values, drives, thermometer, other in states:
        device.ps7.pin_value.value = values
        device.ps7.pin_drives.value = drives | others * other
        dut.thermometer_scl.value = thermometer & 1
        dut.thermometer_sda.value = thermometer >> 1
        await Timer(1, "ns")
        levels = 3 & ~(thermometer | drives & ~values)
        found = f"{dut.sda.value}{dut.scl.value}"
        assert found == f"{levels:02b}", (values, drives, thermometer, other)
        assert int(device.ps7.pin_level.value) == levels
    device.ps7.pin_drives.value = 0


@cocotb.test()
async def the_chip_is_identified(dut: Any) -> None:
    """The identifier of the chip is complete when it is reported as known, and the fabric reads it
    again after a reset."""
    device = await started(dut)
    names = device.registers
    for _ in range(2):
        assert await names.read("chip_dna_high.known") == 0
        await ClockCycles(device.clock, DNA_CLOCKS)
        assert await names.read("chip_dna_high.known") == 1
        high, low = await names.read("chip_dna_high.value"), await names.read("chip_dna_low")
        assert high << 32 | low == DNA
        device.ps7.fabric_resetn.value = 0
        await ClockCycles(device.clock, RESET_CLOCKS)
        await device.let_go()


@cocotb.test()
async def leds_show_the_state(dut: Any) -> None:
    device = await started(dut)
    names = device.registers
    await device.configure()
    await ClockCycles(device.clock, 3 * WINDOW)
    assert device.lit()[1:] == (0, 0, 0)
    # The LED alive is on for 8 windows and off for 8.
    changes, before = [], device.lit()[0]
    for clock in range(34 * WINDOW):
        await FallingEdge(device.clock)
        if device.lit()[0] != before:
            changes.append(clock)
            before = device.lit()[0]
    assert np.diff(changes).tolist() == [8 * WINDOW] * (len(changes) - 1)
    assert len(changes) == 4
    # The LED fault is on until the processor has cleared the fault.
    for level in (1, 0):
        device.drive("head2_a", level)
        device.drive("head2_b", level)
        await ClockCycles(device.clock, 20)
    await ClockCycles(device.clock, 2 * WINDOW)
    assert device.lit()[1:] == (0, 1, 0)
    await names.command("clear_head1")
    await ClockCycles(device.clock, 3 * WINDOW)
    assert device.lit()[2] == 1
    await names.command("clear_head2")
    await ClockCycles(device.clock, 3 * WINDOW)
    assert device.lit()[1:] == (0, 0, 0)
    # The LEDs capture and compensation stay off until the index has come.
    await names.update("control", capture_enable=1, compensate=1)
    await ClockCycles(device.clock, 3 * WINDOW)
    assert device.lit()[1:] == (0, 0, 0)
    await device.turn(table.motion(0.5, CLOCKS_PER_COUNT))
    await ClockCycles(device.clock, 3 * WINDOW)
    assert device.lit()[1:] == (1, 0, 1)
    await names.update("control", compensate=0)
    await ClockCycles(device.clock, 3 * WINDOW)
    assert device.lit()[1:] == (1, 0, 0)


@cocotb.test()
async def reset_in_the_middle(dut: Any) -> None:
    """During a reset while the table turns, A and B keep their levels, Z is low, LEDs are off and
    registers have their reset values; after the reset the core works again."""
    device = await started(dut)
    names = device.registers
    for wait_ns in (1, 4, 6, 9):  # before and after both edges of the clock
        await device.configure()
        await names.update("control", output_enable=1, capture_enable=1, compensate=1)
        await device.turn(table.motion(0.6, CLOCKS_PER_COUNT))
        await RisingEdge(device.clock)
        await Timer(wait_ns, "ns")
        device.ps7.fabric_resetn.value = 0
        # An edge that is already in the output's pipeline still comes; after that the levels of A
        # and B do not change.
        await ClockCycles(device.clock, 8)
        held = [device.level(name) for name in ("out_a", "out_b")]
        reset_lasts = 0
        turning = cocotb.start_soon(device.turn(table.motion(0.3, CLOCKS_PER_COUNT)))
        for _ in range(100):
            await FallingEdge(device.clock)
            assert device.lit() == (0, 0, 0, 0)
            assert [device.level(name) for name in ("out_a", "out_b", "out_z")] == [*held, 0]
        await turning
        # An access that begins now is answered after the end of the reset.
        reading = cocotb.start_soon(device.axi.read_burst(BASE, 2))
        writing = cocotb.start_soon(
            device.axi.write_burst(BASE + registers.COEFFICIENTS_ADDRESS, [3])
        )
        await ClockCycles(device.clock, 200)
        assert not reading.done()
        assert not writing.done()
        await Timer(wait_ns, "ns")
        device.ps7.fabric_resetn.value = 1
        while not reading.done() or not writing.done():
            await FallingEdge(device.clock)
            await ReadOnly()
            reset_lasts += int(device.top.reset.value)
            await RisingEdge(device.clock)
        assert RESET_CLOCKS <= reset_lasts <= RESET_RELEASE_CLOCKS
        assert [answer for _, answer in await reading] == [OKAY, OKAY]
        assert await writing == OKAY
        assert await names.read_fields("control") == dict.fromkeys(
            await names.read_fields("control"), 0
        )
        assert await names.read("head1.flags.index_seen") == 0
        assert await names.read("interrupt_status.head1_fault") == 0
