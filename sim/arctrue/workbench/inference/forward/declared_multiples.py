"""Multiples of the rate that a measurement set declares, such as the tooth count of its drive."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.inference.forward.scan_of_rates import scan
from arctrue.workbench.inference.forward.tests_of_a_line import (
    DECLARED_PERIODS,
    needed_gain,
    periods_in,
)
from arctrue.workbench.noise.kernel import KernelNoise

Float = NDArray[np.float64]

MOST_MULTIPLE = 8
"""Highest multiple of a declared rate that is searched."""


def multiples_of_declared(record: Record) -> Float:
    """Return the multiples of the declared rate that the record can show; empty without such a
    rate."""
    if record.declared is None:
        return np.zeros(0)
    found = record.declared * np.arange(1, MOST_MULTIPLE + 1)
    lowest = max(DECLARED_PERIODS / record.span, 1.0 / record.longest)
    return np.asarray(found[(found >= lowest) & (found <= record.highest_declared)])


def nearest_multiple(record: Record, rate: float) -> int | None:
    """Return k if this rate equals k times the declared rate within the resolution of the record;
    None without such a k."""
    if record.declared is None:
        return None
    times = round(rate / record.declared)
    near = abs(rate - times * record.declared) * record.span
    return times if 1 <= times <= MOST_MULTIPLE and near < 0.5 else None


def needed_at(record: Record, rate: float, gain: float) -> float:
    """Return the gain that a line at this rate needs to be significant; near a multiple of the
    declared rate, only the multiples count as trials."""
    declared = nearest_multiple(record, rate) is not None
    independent = float(multiples_of_declared(record).size) if declared else record.independent
    return needed_gain(gain, max(independent, 1.0))


def factors_of(record: Record, rates: Sequence[float], noise: KernelNoise) -> list[int | None]:
    """Return, for each line, the factor by which it is a multiple of the declared rate; None if it
    is not a multiple.

    A line at the multiple must explain the error as well as the line at its own rate, with all
    other lines in the model. If the record can show the declared rate itself and contains no line
    there, the multiples need closer agreement: a gear usually causes a line at the declared rate
    too.
    """
    near = [nearest_multiple(record, rate) for rate in rates]
    penalty = float(np.log(record.clock.size))
    lost: list[float] = []
    found: list[int | None] = []
    for rate, times in zip(rates, near, strict=True):
        if times is None or record.declared is None:
            lost.append(float("inf"))
            found.append(None)
            continue
        others = record.columns(np.array([other for other in rates if other != rate]))
        gains = scan(record, np.array([rate, times * record.declared]), others, noise)
        lost.append(2.0 * float(gains[0] - gains[1]))
        most = max(penalty + AS_GOOD, 2.0 * MODULATED * float(gains[0]))
        found.append(times if lost[-1] < most else None)
    own = record.declared is None or periods_in(record, record.declared) < DECLARED_PERIODS
    if own or 1 in found:
        return found
    return [times if lost[at] < penalty else None for at, times in enumerate(found)]


AS_GOOD = 6.0
"""BIC advantage that a line of its own rate needs over a line at a multiple of the declared rate:
odds of 20 to 1. A free rate is one more parameter."""
MODULATED = 0.01
"""Share of a line's gain that the line at the multiple may lose in any case: if the phase of a gear
wanders by 0.2 rad RMS, a wrong rate may gain 0.2²/4 = 1 % more than the true one."""
