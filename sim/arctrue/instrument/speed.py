"""Measures how fast a simulator runs while every lane is active and the table turns under both
heads."""

from __future__ import annotations

import time

import numpy as np

from arctrue.gateware.coefficients import Coefficients
from arctrue.instrument.instrument import Instrument, clock_hz_for
from arctrue.table import Motion, RotaryTable, two_heads

COUNTS_PER_REV = 1 << 24


def busy_coefficients(lanes: int) -> Coefficients:
    """Return coefficients in which lane n − 1 has order n, with an amplitude of a tenth of a count
    and its own phase."""
    order = np.arange(1, lanes + 1)
    return Coefficients(
        phase_steps=(order << (48 - 24)).astype(np.uint64),
        phase_offsets=(order * 12345).astype(np.uint32),
        amplitudes=np.full(lanes, 205, dtype=np.int32),
        offset=0,
        counts_per_rev=COUNTS_PER_REV,
    )


def clocks_per_second(instrument: Instrument, lanes: int, clocks: int) -> float:
    """Return the clocks simulated per second of processor time, at 1.1 clocks per count.

    Processor time, unlike wall time, does not depend on other programs.
    """
    table = RotaryTable(heads=two_heads(), counts_per_rev=COUNTS_PER_REV)
    speed = 1.0
    instrument.clock_hz = clock_hz_for(COUNTS_PER_REV, speed, 1.1)
    motion = Motion.steady(speed, (clocks + 1000) / instrument.clock_hz, start_rad=-1e-5)
    instrument.reset()
    instrument.write_coefficients(busy_coefficients(lanes))
    instrument.command("swap")
    instrument.update("control", compensate=1, output_enable=1)
    instrument.attach(table, motion)
    started = time.process_time()
    instrument.run(clocks)
    took = time.process_time() - started
    instrument.detach()
    return clocks / took
