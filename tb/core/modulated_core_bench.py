"""Tests in cocotb that the amplitudes of a core with MODULATORS follow the motion at its pins.

The table turns up, reverses and turns down. In every clock the correction equals that of the
models, in which the amplitude of each lane is its nominal amplitude times its modulator of the last
sweep.
"""

from __future__ import annotations

from typing import Any

import cocotb
import numpy as np
from cocotb.triggers import FallingEdge
from numpy.typing import NDArray

from arctrue.gateware.amplitude_sweep import Modulators, effective_amplitudes
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.error_compensation import add_pairs, correction_limit, subtract
from arctrue.gateware.extension import Conditions
from arctrue.gateware.harmonic_unit import harmonic_unit
from arctrue.gateware.phase_unit import phase_unit
from arctrue.gateware.table_conditions import MODULATOR_ONE
from arctrue.generated.number_formats import (
    AMPLITUDE_CLOCK,
    AMPLITUDE_SWEEP_CLOCKS,
    PAIR_FRACTION,
    PHASE_LATENCY,
    PIPELINE_LATENCY,
)
from tb.core import arctrue_core_table as table
from tb.core.arctrue_core_bench import CLOCKS_PER_COUNT, LANES, ROTATION, Machine, prepared

WIDTH_COUNTS = 150
DEAD_ZONE = 4
NOMINAL = 0.25
"""Nominal speed in counts per clock; the table's mean speed is a fifth of a count per clock."""
WORD_A = -40_000
UP_TURNS, DOWN_TURNS = 12.0, 1.5
"""Numbers of turns up and down; the turns up last longer than two windows of the speed, 2·2¹⁴
clocks."""
WRITE_CLOCKS = 6
"""Number of clocks from a step of the sweep to the first read that returns the word which this step
writes."""
READ_CLOCKS = PHASE_LATENCY + AMPLITUDE_CLOCK - 1
"""Number of clocks from an angle to the clock in which its amplitude is read."""
FIRST_LANE_STEP = 64
"""Number of the step of the sweep that writes lane 0 of the bank in use."""


def bank() -> Coefficients:
    """Return a bank with a lane of each kind: without a modulator, with direction, with speed, and
    order 0 with word A."""
    made = Coefficients.from_harmonics(
        [1, 2, 3, 0], [5.0, 6.0, 4.0, 8.0], [0.4, -1.1, 2.0, 0.0], table.COUNTS_PER_REV, LANES
    )
    followed = ((1, "direction"), (2, "speed"), (3, "word_a"))
    # The test writes the nominal speed of this table directly to the register, because it is faster
    # than any real table.
    conditions = Conditions(16 * WIDTH_COUNTS, DEAD_ZONE, nominal_deg_per_s=90.0)
    extension = Extension(conditions=conditions, modulators=followed)
    return Coefficients(
        made.phase_steps,
        made.phase_offsets,
        made.amplitudes,
        0,
        table.COUNTS_PER_REV,
        None,
        extension,
    )


class Log:
    """Records inputs and outputs of the pipeline and of the sweep in each clock."""

    INPUTS = ("angle", "position", "sweep_step")
    SIGNED = ("position", "correction", "corrected_position", "direction", "speed", "word_a")
    NAMES = ("angle", "sweep_step", *SIGNED)

    def __init__(self, dut: Any) -> None:
        self.dut = dut
        self.rows: list[list[int]] = []

    async def run(self) -> None:
        unit = self.dut.unit.compensation
        signals = [(getattr(unit, name), name in self.SIGNED) for name in self.NAMES]
        while True:
            await FallingEdge(self.dut.clock)
            self.rows.append(
                [
                    signal.value.to_signed() if signed else signal.value.to_unsigned()
                    for signal, signed in signals
                ]
            )

    def columns(self) -> dict[str, NDArray[np.int64]]:
        rows = np.array(self.rows, dtype=np.int64)
        return {name: rows[:, place] for place, name in enumerate(self.NAMES)}


def amplitudes_read(seen: dict[str, NDArray[np.int64]], loaded: Coefficients) -> NDArray[np.int64]:
    """Return the amplitudes (clocks, lanes) that a read in each clock would return; they are valid
    from the end of the first whole sweep on."""
    clocks = seen["sweep_step"].size
    found = np.zeros((clocks + WRITE_CLOCKS, LANES), dtype=np.int64)
    held = Modulators()
    for clock, step in enumerate(seen["sweep_step"].tolist()):
        lane = step - FIRST_LANE_STEP
        if 0 <= lane < LANES:
            modulator = held.values[loaded.modulator_numbers[lane]]
            found[clock + WRITE_CLOCKS :, lane] = effective_amplitudes(
                loaded.amplitudes[lane], modulator
            )
        if step == AMPLITUDE_SWEEP_CLOCKS - 1:
            held = Modulators(
                *(int(seen[name][clock]) for name in ("direction", "speed", "word_a"))
            )
    return found


async def set_up(machine: Machine) -> Coefficients:
    names = machine.registers
    assert (await names.read_fields("capability"))["modulators"] == 1
    loaded = bank()
    await names.write("conditions.width", 16 * WIDTH_COUNTS)
    await names.write("conditions.dead_zone", DEAD_ZONE)
    await names.write("conditions.nominal_speed", round(NOMINAL * 2**32))
    await names.write("conditions.word_a", WORD_A)
    await names.write("conditions.slew", 0xFFFF_FFFF)
    await names.write_coefficients(loaded)
    await names.command("swap")
    await names.update("control", output_enable=1, compensate=1)
    return loaded


@cocotb.test()
async def every_clock_is_the_models(dut: Any) -> None:
    """After the ramp, the core equals the models in every clock, during several windows of the
    speed measurement and a reversal."""
    machine = await prepared(dut)
    loaded = await set_up(machine)
    log = Log(dut)
    up = table.motion(UP_TURNS, CLOCKS_PER_COUNT)
    down = up[-1] - np.arange(int(DOWN_TURNS * table.COUNTS_PER_REV * 5)) / CLOCKS_PER_COUNT
    first = int(1.5 * table.COUNTS_PER_REV * CLOCKS_PER_COUNT)
    await machine.turn(up[:first])
    status = await machine.registers.read_fields("status")
    assert (status["compensating"], status["ramp_busy"]) == (1, 0)
    cocotb.start_soon(log.run())
    await machine.turn(up[first:])
    turned_at = len(log.rows)
    await machine.turn(down)

    seen = log.columns()
    amplitudes = amplitudes_read(seen, loaded)
    # The amplitudes are known only after a whole sweep.
    clock = np.arange(2 * AMPLITUDE_SWEEP_CLOCKS, seen["sweep_step"].size - PIPELINE_LATENCY)
    angles, positions = seen["angle"][clock], seen["position"][clock]
    phases = phase_unit(angles, loaded.phase_steps, loaded.phase_offsets)
    products = harmonic_unit(phases, amplitudes[clock + READ_CLOCKS], rotation=ROTATION)
    sums = add_pairs(products, 0)
    limit = correction_limit(table.COUNTS_PER_REV) << PAIR_FRACTION
    model = subtract(angles, positions, np.clip(sums, -limit, limit), table.COUNTS_PER_REV)
    for name, expected in (
        ("correction", model.correction),
        ("corrected_position", model.corrected_position),
    ):
        found = seen[name][clock + PIPELINE_LATENCY]
        apart = np.flatnonzero(found != expected)
        assert not apart.size, (name, clock[apart[:5]], apart.size)

    # Check that the modulators follow the motion, because the comparison above takes the modulators
    # from the core.
    settled = turned_at + int(4 * WIDTH_COUNTS * CLOCKS_PER_COUNT)
    assert set(seen["direction"][:turned_at]) == {MODULATOR_ONE}
    assert set(seen["direction"][settled:]) == {-MODULATOR_ONE}
    assert set(seen["word_a"]) == {WORD_A}
    assert np.unique(amplitudes[AMPLITUDE_SWEEP_CLOCKS * 2 :, 1]).size > 5, (
        "constant over the reversal"
    )
    # A window of 2^14 clocks averages the speed over some 5.5 turns; the ripple of the speed has 7
    # periods per turn.
    speed = seen["speed"][turned_at - 1] / MODULATOR_ONE
    assert abs(speed * NOMINAL * CLOCKS_PER_COUNT - 1.0) < 0.02, speed
    # Up to a constant, the core's position equals the reading at the pins of head 1 a few clocks
    # earlier.
    reading = np.array(machine.reading[-seen["position"].size :])[:, 0]
    apart = [seen["position"][20:] - reading[20 - lag : reading.size - lag] for lag in range(20)]
    assert sum(np.ptp(way) == 0 for way in apart) == 1, "the position is not that of the pins"
