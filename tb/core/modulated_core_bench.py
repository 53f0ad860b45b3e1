"""cocotb tests of the core with modulators: what a reversal adds to the pins is gone."""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles, FallingEdge
from numpy.typing import NDArray

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.extension import Conditions, Extension
from arctrue.gateware.register_access import RegisterMap
from arctrue.generated import number_formats
from tb.core import arctrue_core_table as table
from tb.registers.axi_lite import BusError, start

LANES = 4
FOLD = int(os.environ.get("FOLD", "1"))
COUNTS = table.COUNTS_PER_REV
LATENCY = number_formats.PIPELINE_LATENCY + FOLD - 1
POSITION_CLOCKS = 5
"""From the pins to a position."""
WIDTH = 60.0
"""Counts in which the wind-up goes over from one side's to the middle."""
HALF_REVERSAL = 7.0


class Table:
    """A table whose disc lags behind it by friction; one entry a clock."""

    def __init__(self, dut: Any, registers: RegisterMap) -> None:
        self.dut, self.registers = dut, registers
        self.now, self.speed, self.wound = -150.0, 0.0, -1.0
        self.half_reversal = 0.0
        self.angle: list[float] = []
        self.corrected: list[int] = []
        self.drive()

    def drive(self) -> None:
        # The reading is where the wound-up disc is: angle + B / 2 · h.
        levels = table.pins(round(self.now + self.half_reversal * self.wound))
        for place, pin in enumerate("abz"):
            getattr(self.dut, f"head1_{pin}").value = levels >> place & 1

    async def run(self) -> None:
        while True:
            self.drive()
            await FallingEdge(self.dut.clock)
            self.angle.append(self.now)
            self.corrected.append(self.dut.unit.corrected_position.value.to_signed())
            self.now += self.speed
            self.wound = min(max(self.wound + self.speed / WIDTH, -1.0), 1.0)

    async def move(self, counts: float, speed: float) -> None:
        self.speed = speed * float(np.sign(counts))
        await ClockCycles(self.dut.clock, round(abs(counts) / speed))
        self.speed = 0.0

    def error(self, first: int, delay: int) -> NDArray[np.float64]:
        """Corrected position less the angle of ``delay`` clocks before, from clock ``first`` on."""
        angle = np.array(self.angle[first - delay : len(self.angle) - delay])
        return np.array(self.corrected[first:]) - angle


async def prepared(dut: Any, half_reversal: float, lanes: Coefficients) -> Table:
    for head in (1, 2, 3, 4):
        for pin in "abz":
            getattr(dut, f"head{head}_{pin}").value = 0
    bus = await start(dut, reset_clocks=64)
    names = bus.registers()
    machine = Table(dut, names)
    machine.half_reversal = half_reversal
    machine.drive()
    await names.write("counts_per_rev", COUNTS)
    await names.command("rearm")
    await names.write("ramp_rate", 0xFFFF_FFFF)
    await names.write("ramp_acceleration", 0)
    await names.write("output_spacing", 1)
    assert await names.read("capability.modulators") == 1
    await names.write("conditions.width", round(16 * WIDTH))
    await names.write("conditions.slew", 1 << 27)
    await names.write_coefficients(lanes)
    await names.command("swap")
    await ClockCycles(dut.clock, 500)
    await names.update("control", compensate=1, output_enable=1)
    cocotb.start_soon(machine.run())
    return machine


def order_0(counts: float, modulator: str) -> Coefficients:
    """One lane of order 0 that follows a condition."""
    bank = Coefficients.from_harmonics(
        [0], [abs(counts)], [0.0 if counts > 0 else np.pi], COUNTS, LANES
    )
    return Coefficients(
        bank.phase_steps,
        bank.phase_offsets,
        bank.amplitudes,
        0,
        COUNTS,
        None,
        Extension(conditions=Conditions(1, 0, 90.0), modulators=((0, modulator),)),
    )


@cocotb.test()
async def reversal_error_is_taken_away(dut: Any) -> None:
    """Up, down and through each reversal the corrected position is the table's angle.

    Bounds: half a count of the reading's rounding and half of the output's; the direction comes up
    to two sweeps and 40 clocks late: 328 clocks · speed · B / 2 / W.
    """
    machine = await prepared(dut, HALF_REVERSAL, order_0(HALF_REVERSAL, "direction"))
    speed = 0.12
    await machine.move(150 + 4 * WIDTH, speed)
    # A turn of the reading and the index are passed; the ramp and the lead-in are over.
    await machine.move(100, speed)
    assert await machine.registers.read("conditions.direction.known") == 1
    first = len(machine.corrected)
    for way in (-150.0, 130.0, -30.0):
        await machine.move(way, speed)
        await ClockCycles(dut.clock, 600)
    error = machine.error(first, LATENCY + POSITION_CLOCKS)
    error -= round(float(np.median(error)) / COUNTS) * COUNTS
    late = 328 * speed * HALF_REVERSAL / WIDTH
    # The reading lags by up to speed · 2 clocks more where pins and corrected clocks are compared.
    bound = 1.0 + late + 0.5
    spread = float(error.max() - error.min()) / 2.0
    dut._log.info(f"off by {spread:.2f} counts at most, bound {bound:.2f}; was {HALF_REVERSAL}")
    assert spread <= bound < HALF_REVERSAL
    standing = machine.error(len(machine.corrected) - 200, LATENCY + POSITION_CLOCKS)
    assert np.ptp(standing) == 0.0, "chatter at standstill"


@cocotb.test()
async def the_window_refuses_what_it_has_not(dut: Any) -> None:
    """Words 0 to 5 are written, 6 to 8 read only, the rest of the window is nobody's."""
    machine = await prepared(dut, 0.0, order_0(1.0, "word_a"))
    names = machine.registers
    for word in range(16):
        address = 0x2100 + 4 * word
        for is_write in (False, True):
            allowed = word < 6 or (word < 9 and not is_write)
            try:
                if is_write:
                    await names._write_words(address, [0])
                else:
                    await names._read_words(address, 1)
                accepted = True
            except BusError:
                accepted = False
            assert accepted == allowed, (word, is_write)
    await names.write("conditions.word_a", -40_000)
    assert await names.read("conditions.word_a") == -40_000
    # The lane's word 1 reads back with its modulator.
    assert (await names._read_words(0x1004, 1))[0] == 4 << 16
