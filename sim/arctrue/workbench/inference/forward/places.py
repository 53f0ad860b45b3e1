"""Chooses the places of a record, that is, the rates with the highest gains, for the further tests
of a line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.declared_multiples import multiples_of_declared, needed_at
from arctrue.workbench.inference.forward.noise_of_record import Level
from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.inference.forward.scan_of_rates import refined, scan
from arctrue.workbench.inference.forward.tests_of_a_line import LEAST_PERIODS, nearest
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import KernelFit

Float = NDArray[np.float64]

TRIED = 3
"""Number of places of each scan, those with the highest gains, that are tested further."""
OVERSAMPLED = 3.0
"""Number of rates per 1/span in a scan: a line midway between two rates keeps 91 % of its gain,
sinc²(1/6)."""
APART = 1.5
"""A place of a scan counts as a side lobe of a higher place if it is nearer to it than this, in
units of 1/span."""


def places_of(
    record: Record, rates: Sequence[float], without: KernelFit, level: Level
) -> Iterator[float]:
    """Yield the rates with the highest gains in the estimated noise or in white noise."""
    others = record.columns(np.array(rates))
    rows = record.rows(others)
    white = KernelNoise(max(float(np.mean(rows.left() ** 2 * rows.readings)), 1e-30))
    grid = _grid(record)
    multiples = multiples_of_declared(record)
    kept: list[float] = []
    for noise in (without.noise, white):
        gains = scan(record, grid, others, noise)
        gains[_near(grid, rates, record)] = 0.0
        of_multiples = scan(record, multiples, others, noise)
        of_multiples[_near(multiples, rates, record)] = 0.0
        places = [*_highest(grid, gains, record), *_highest(multiples, of_multiples, record)]
        for rate in places:
            moved = rate
            if not record.whole_orders_only:
                moved = refined(record, rate, others, noise)
            if nearest([*rates, *kept], moved) * record.span >= SAME_PLACE:
                kept.append(moved)
    for rate in kept:
        if nearest(rates, rate) * record.span < 1.0:
            continue
        gain = float(scan(record, np.array([rate]), others, without.noise)[0])
        least = LITTLE * needed_at(record, rate, gain) * level.at(record, rate)
        if gain > least or takes_much(record, others, record.line_columns(rate)):
            yield rate


LITTLE = 0.5
"""A rate is tested if its gain in the scan exceeds this share of the needed gain; a new estimate of
the noise does not raise a smaller gain to the limit."""
SAME_PLACE = 0.1
"""Two scans have found the same line if their rates differ by less than this, in units of
1/span."""


def _grid(record: Record) -> Float:
    lowest = LEAST_PERIODS / record.span
    lowest = max(lowest, 1.0 / record.longest)
    if record.whole_orders_only:
        return np.arange(np.ceil(lowest), np.floor(record.highest) + 1.0)
    count = max(int((record.highest - lowest) * record.span * OVERSAMPLED), 1)
    return np.linspace(lowest, record.highest, count)


def _near(grid: Float, rates: Sequence[float], record: Record) -> NDArray[np.bool_]:
    found = np.zeros(grid.size, dtype=bool)
    for rate in rates:
        found |= np.abs(grid - rate) * record.span < 1.0
    return found


def _highest(grid: Float, gains: Float, record: Record) -> list[float]:
    """Return the places with the highest gains, without the neighbours of a higher place."""
    left = gains.copy()
    found: list[float] = []
    while len(found) < TRIED and left.size and float(left.max()) > 0.0:
        at = int(np.argmax(left))
        found.append(float(grid[at]))
        left[np.abs(grid - grid[at]) * record.span < APART] = 0.0
    return found


def takes_much(record: Record, others: Float, line: Float) -> bool:
    """Return True if the line removes more than the share MUCH of the residuals' squares."""
    before = record.rows(others).left()
    after = record.rows(np.hstack([others, line])).left()
    return float(after @ after) < (1.0 - MUCH) * float(before @ before)


MUCH = 0.05
"""If a line removes more than this share of the residuals' sum of squares, the search for the noise
also begins at the usual starts."""
