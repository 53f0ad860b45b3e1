"""Finds single rows that are wrong in a recording, before any model is fitted.

A row, alone or with at most two neighbours, is an outlier if its value is far from the values
before it and after it. In addition, no similar deviation may occur at the same angle in other
revolutions. Real deviations differ from outliers: after a lost count the deviation stays, a scratch
recurs at its angle in both heads, and a vibration continues.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.observations.outliers.far_rows import (
    MOST_ROWS,
    NORMAL_MAD,
    SIDE_ROWS,
    far_from_neighbours,
    far_threshold,
    lonely,
)
from arctrue.workbench.observations.outliers.missing_rows import (
    LEAST_ROWS,
    pieces_between_gaps,
    without_wave,
)
from arctrue.workbench.observations.outliers.seen_again import (
    at_every_visit,
    repeats,
    seen_by_other_head,
)

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Boolean = NDArray[np.bool_]

OF_A_STEP = 0.5
"""A row belongs to one side of a step if its distance from the rows on that side is at most this
share of its distance from the rows on both sides. An outlier has about the same distance from both
sides. Half of that distance is at least NEAR_SIGMA, because an outlier is FAR_SIGMA away."""
MOST_SHARE = 0.05
"""Largest share of outliers; with a larger share the recording is faulty."""
LEAST_VISITS = 4
"""Smallest number of readings of a station among which a single wrong reading can be recognised."""
LEAST_PASS_ROWS = 3
"""Smallest number of rows of a pass in which a single wrong reading can be recognised: two other
rows then agree with each other."""


def capture_outliers(
    difference_arcsec: Float,
    angle_rad: Float,
    revolution: Integer,
    spans: list[tuple[int, int]],
    separation_rad: float,
    count_arcsec: float,
) -> tuple[Boolean, Float]:
    """Return True for outliers of R₂ − R₁, and the distance of each row from the rows around it;
    (rows,).

    ``spans``: first row of each run and the row after its last. A run of fewer than LEAST_ROWS rows
    is not examined; the distances of its rows are 0.
    """
    away = np.zeros(difference_arcsec.size)
    scatter = np.ones(difference_arcsec.size)
    found = np.zeros(difference_arcsec.size, dtype=bool)
    flat, number = difference_arcsec.copy(), np.zeros(difference_arcsec.size, dtype=np.int64)
    for label, (start, end) in enumerate(spans):
        if end - start < LEAST_ROWS:
            continue
        number[start:end] = label
        angle = angle_rad[start:end]
        flat[start:end] = without_wave(difference_arcsec[start:end], angle)
        away[start:end], scatter[start:end] = far_from_neighbours(
            flat[start:end],
            count_arcsec,
            count_arcsec,
            pieces_between_gaps(angle),
        )
        threshold = far_threshold(away.size, end - start - 2 * SIDE_ROWS)
        found[start:end] = lonely(away[start:end], scatter[start:end], threshold)
    rows = np.flatnonzero(found)
    real = repeats(rows, away, scatter, angle_rad, revolution)
    real |= at_a_step(rows, flat, away, number)
    real |= seen_by_other_head(rows, away, scatter, angle_rad, revolution, separation_rad)
    found[rows[real]] = False
    return found, away


def station_outliers(
    error_arcsec: Float, station: Integer, order_of_visit: Integer, sense: Integer, least: float
) -> tuple[Boolean, Float]:
    """Find outliers among readings of stations that were visited LEAST_VISITS times or more.

    Returns True for outliers, and the distance of each row from its expected value; shapes (rows,).
    ``station``: number of the station of each row. ``order_of_visit``: label of the pass of each
    row; the rows of a pass are consecutive. ``sense``: sense of motion, 1 or −1. The expected value
    is the sum of the pass's median, the median of the station's other readings, and a running
    median of the pass: a whole pass may deviate (another temperature, another direction).
    """
    edges = np.flatnonzero(np.diff(order_of_visit)) + 1
    size = np.diff([0, *edges.tolist(), error_arcsec.size])
    pass_of = np.repeat(np.arange(size.size), size)
    away = error_arcsec - _medians(error_arcsec, pass_of)
    # The median of a pass of one or two rows follows its rows. It does not show by how much the
    # pass deviates, so that these rows must not enter the median of their stations.
    short = size[pass_of] < LEAST_PASS_ROWS
    station = np.where(short, int(station.max(initial=0)) + 1 + np.arange(station.size), station)
    away -= of_the_others(away, station)
    level = away.copy()
    away -= _around(away, pass_of, size)
    known = (np.bincount(station)[station] >= LEAST_VISITS) & ~short
    if not known.any():
        return np.zeros(away.size, dtype=bool), away
    scatter = max(NORMAL_MAD * float(np.median(np.abs(away[known]))), least)
    threshold = far_threshold(away.size, int(known.sum()))
    found = lonely(np.where(known, away, 0.0), np.full(away.size, scatter), threshold)
    rows = np.flatnonzero(found)
    real = at_every_visit(rows, away, scatter, station, sense)
    real |= at_a_step(rows, level, away, pass_of)
    found[rows[real]] = False
    return found, away


def at_a_step(rows: Integer, values: Float, away: Float, piece: Integer) -> Boolean:
    """Tell for each of ``rows`` whether it agrees with the rows on one side, so that the values
    change there and stay.

    ``values``, ``away``, ``piece`` (number of the pass): shapes (all rows,). The result is True if
    the row differs by less than OF_A_STEP of ``away`` from most of the SIDE_ROWS rows before or
    after it in its piece, and from at least MOST_ROWS of them. A group of outliers has at most
    MOST_ROWS rows, so that fewer others agree with one of its rows.
    """
    found = np.zeros(rows.size, dtype=bool)
    for number, row in enumerate(rows.tolist()):
        for side in (slice(max(row - SIDE_ROWS, 0), row), slice(row + 1, row + 1 + SIDE_ROWS)):
            own = values[side][piece[side] == piece[row]]
            most = max(own.size // 2 + 1, MOST_ROWS)
            near = np.abs(own - values[row]) < OF_A_STEP * abs(away[row])
            found[number] |= np.count_nonzero(near) >= most
    return found


def _medians(values: Float, group: Integer) -> Float:
    """Return, for each value, the median of its group; groups are numbered from 0; (rows,)."""
    ordered = values[np.lexsort((values, group))]
    count = np.bincount(group)
    first = np.cumsum(count) - count
    middle = ordered[first + (count - 1) // 2] + ordered[first + count // 2]
    return np.asarray(0.5 * middle[group])


def of_the_others(values: Float, group: Integer) -> Float:
    """Return, for each value, the median of all other values of its group, 0 for a single value;
    (rows,).

    The value itself is left out. If the median could be the value itself, its distance would be 0
    too often, and the scatter of these distances would be too small for the other rows.
    """
    order = np.lexsort((values, group))
    ordered, count = values[order], np.bincount(group)[group[order]]
    first = np.searchsorted(group[order], group[order])
    rank, others = np.arange(values.size) - first, count - 1
    middle = np.zeros(values.size)
    for place in ((others - 1) // 2, others // 2):
        at = first + place + (place >= rank)
        middle += 0.5 * ordered[np.minimum(at, values.size - 1)]
    expected = np.empty(values.size)
    expected[order] = np.where(others > 0, middle, 0.0)
    return expected


def _around(values: Float, pass_of: Integer, size: Integer) -> Float:
    """Return, for each row, the median of the SIDE_ROWS rows around it in its pass, without the row
    itself.

    ``pass_of``: number of each row's pass; ``size``: rows of each pass. In a short pass, the median
    of all other rows is returned. A pass of fewer than three rows cannot show a wrong row; its own
    values are returned, so that their distances become 0. Shape (rows,).
    """
    expected = of_the_others(values, pass_of)
    rows = np.flatnonzero(size[pass_of] > SIDE_ROWS + 1)
    last = (np.cumsum(size) - 1)[pass_of[rows]]
    first = last + 1 - size[pass_of[rows]]
    half = (SIDE_ROWS + 1) // 2
    around = []
    for shift in (*range(-half, 0), *range(1, half)):
        # Beyond the ends of the pass, its rows are mirrored.
        place = np.where(rows + shift < first, 2 * first - rows - shift, rows + shift)
        around.append(values[np.where(place > last, 2 * last - place, place)])
    expected[rows] = np.median(around, axis=0)
    return np.where(size[pass_of] < LEAST_PASS_ROWS, values, expected)
