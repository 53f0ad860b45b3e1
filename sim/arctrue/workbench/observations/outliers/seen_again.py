"""Tests whether a deviation recurs in other revolutions, at the other head, or at other visits of a
station."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.observations.outliers.far_rows import FAR_SIGMA, NEAR_SIGMA

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Boolean = NDArray[np.bool_]

SAME_PLACE_ROWS = 1.5
"""Largest distance, in steps between rows, of rows in different revolutions that count as the same
angle."""
MOST_COMPARED = 20_000
"""Largest number of outliers that are compared with other revolutions; if there are more, all of
them count as wrong rows."""


def repeats(
    rows: Integer, away: Float, scatter: Float, angle_rad: Float, revolution: Integer
) -> Boolean:
    """Tell for each of ``rows`` whether other revolutions have a similar deviation at the same
    angle.

    ``away``, ``scatter``, ``angle_rad``, ``revolution``: shapes (all rows,). The result is True if
    the median, over the other revolutions, of the largest deviation of the same sign at this angle
    exceeds NEAR_SIGMA standard deviations.
    """
    found = np.zeros(rows.size, dtype=bool)
    if rows.size == 0 or rows.size > MOST_COMPARED:
        return found
    for number, row, there in _rows_at(rows, angle_rad, (0.0,)):
        there = there[revolution[there] != revolution[row]]
        if there.size == 0:
            continue
        same_sense = np.sign(away[row]) * away[there] / scatter[there]
        found[number] = _in_most_revolutions(same_sense, revolution[there]) > NEAR_SIGMA
    return found


def _rows_at(
    rows: Integer, angle_rad: Float, shifts_rad: tuple[float, ...]
) -> Iterator[tuple[int, int, Integer]]:
    """Yield, for each of ``rows`` and each shift, the number of the row among ``rows``, the row,
    and all rows at the row's angle plus the shift."""
    place = np.mod(angle_rad, 2.0 * np.pi)
    order = np.argsort(place, kind="stable")
    sorted_place = place[order]
    step = float(np.median(np.abs(np.diff(angle_rad)))) if angle_rad.size > 1 else 0.0
    for number, row in enumerate(rows.tolist()):
        for shift in shifts_rad:
            at = np.mod(place[row] + shift, 2.0 * np.pi) if shift else place[row]
            first = np.searchsorted(sorted_place, at - SAME_PLACE_ROWS * step)
            last = np.searchsorted(sorted_place, at + SAME_PLACE_ROWS * step, side="right")
            yield number, row, order[first:last]


def _in_most_revolutions(values: Float, revolution: Integer) -> float:
    """Return the median, over the revolutions, of the largest value in each revolution; both
    arguments (rows,)."""
    turns, inverse = np.unique(revolution, return_inverse=True)
    largest = np.full(turns.size, -np.inf)
    np.maximum.at(largest, inverse, values)
    return float(np.median(largest))


def seen_by_other_head(
    rows: Integer,
    away: Float,
    scatter: Float,
    angle_rad: Float,
    revolution: Integer,
    separation_rad: float,
) -> Boolean:
    """Tell for each of ``rows`` whether R₂ − R₁ has the opposite deviation at the angle of the
    other head.

    Each point of the disc passes both heads in every revolution, so that its error appears twice in
    R₂ − R₁, with opposite signs, at angles that differ by α. The result is True if the median over
    the revolutions of the opposite deviation exceeds FAR_SIGMA standard deviations. One revolution
    alone is not sufficient: if one row in 300 is wrong, a tenth of the outliers have such a partner
    by chance in at least one of a dozen turns.
    """
    found = np.zeros(rows.size, dtype=bool)
    if rows.size == 0 or rows.size > MOST_COMPARED:
        return found
    for number, row, there in _rows_at(rows, angle_rad, (separation_rad, -separation_rad)):
        if there.size:
            opposite = -np.sign(away[row]) * away[there] / scatter[there]
            found[number] |= _in_most_revolutions(opposite, revolution[there]) > FAR_SIGMA
    return found


def at_every_visit(
    rows: Integer, away: Float, scatter: float, station: Integer, sense: Integer
) -> Boolean:
    """Tell for each of ``rows`` whether other passes with the same sense of motion have a similar
    deviation at the same station.

    ``away``, ``station``, ``sense`` (1 up, −1 down): shapes (all rows,). An effect of a reversal
    recurs after each reversal. The result is True if the median of the deviations in these passes,
    times the sign of the row's own deviation, exceeds NEAR_SIGMA standard deviations.
    """
    found = np.zeros(rows.size, dtype=bool)
    if rows.size > MOST_COMPARED:
        return found
    place = 2 * station + (sense > 0)
    order = np.argsort(place, kind="stable")
    ordered = place[order]
    for number, row in enumerate(rows.tolist()):
        first, last = np.searchsorted(ordered, [place[row], place[row] + 1])
        there = order[first:last]
        there = there[there != row]
        if there.size:
            products = np.sign(away[row]) * away[there]
            found[number] = float(np.median(products)) > NEAR_SIGMA * scatter
    return found
