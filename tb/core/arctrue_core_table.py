"""Simulates a small table for tests of the core: the pins of two heads and a disc's known error.

All values are in counts of a turn of 600 counts. Angles of the table are real numbers; readings are
rounded to whole counts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

COUNTS_PER_REV = 600
"""Number of counts per turn, which is small and not a power of two."""

SEPARATION_COUNTS = 55.0
"""Angle between the heads in counts, 33 degrees."""

HARMONICS = ((1, 6.0, 0.4), (2, 2.5, -1.1), (5, 0.8, 2.0))
"""Order, amplitude in counts and phase in radians of each harmonic of the disc's error."""

START_COUNTS = -130.0
"""Angle in counts at which the table starts. In the first quarter turn both heads pass their index,
head 2 before head 1."""

_PHASE_PINS = (0b00, 0b01, 0b11, 0b10)  # A in bit 0, B in bit 1; A leads upwards


def error_counts(angle_counts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the disc's error in counts at these angles (n,) between disc and head."""
    turn = 2.0 * np.pi / COUNTS_PER_REV
    return sum(
        (amplitude * np.cos(order * turn * angle_counts + phase))
        for order, amplitude, phase in HARMONICS
    ) + np.zeros_like(angle_counts)


def readings(angle_counts: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return readings (n, 2) of both heads at table angles (n,), counted from each head's index."""
    shifted = angle_counts + SEPARATION_COUNTS
    head1 = angle_counts + error_counts(angle_counts)
    head2 = shifted + error_counts(shifted)
    return np.rint(np.column_stack([head1, head2])).astype(np.int64)


def motion(turns: float, clocks_per_count: float) -> NDArray[np.float64]:
    """Return the table's angle in counts in each clock: it rises from START_COUNTS; the speed
    varies by 10 %."""
    clocks = int(turns * COUNTS_PER_REV * clocks_per_count)
    travelled = np.arange(clocks) / clocks_per_count
    ripple = 0.1 * COUNTS_PER_REV / (2.0 * np.pi * 7)
    return START_COUNTS + travelled + ripple * np.sin(2.0 * np.pi * 7 * travelled / COUNTS_PER_REV)


def pins(reading: int, index_scatter: Sequence[int] = (0,)) -> int:
    """Return A, B and Z in bits 0 to 2. ``index_scatter`` has the displacements, in counts, of the
    index marks in successive turns."""
    turn = (reading + COUNTS_PER_REV // 2) // COUNTS_PER_REV
    at_index = reading - turn * COUNTS_PER_REV == index_scatter[turn % len(index_scatter)]
    return _PHASE_PINS[reading % 4] | (0b100 if at_index else 0)


def harmonics_from_capture(samples: NDArray[np.int64]) -> list[tuple[int, float, float]]:
    """Return order, amplitude (counts) and phase (rad) of the error as a function of the reading.

    R2 - R1 minus the heads' separation equals the error at R2 minus the error at R1. Ordinary least
    squares fits this equation to ``samples``, the readings (n, 2). The fit has one order more than
    the disc; this order absorbs the difference between reading and angle.
    """
    turn = 2.0 * np.pi / COUNTS_PER_REV
    orders = sorted({order for order, _, _ in HARMONICS} | {3})
    columns = [np.ones(len(samples))]
    for order in orders:
        angle = order * turn * samples
        columns += [np.diff(np.cos(angle))[:, 0], np.diff(np.sin(angle))[:, 0]]
    difference = np.diff(samples)[:, 0].astype(np.float64)
    solution = np.linalg.lstsq(np.column_stack(columns), difference, rcond=None)[0]
    return [
        (order, float(np.hypot(cosine, sine)), float(np.arctan2(-sine, cosine)))
        for order, cosine, sine in zip(orders, solution[1::2], solution[2::2], strict=True)
    ]
