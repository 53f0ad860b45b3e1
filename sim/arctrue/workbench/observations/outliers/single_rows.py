"""Finds single rows that are wrong in a recording, before any model is fitted.

A row, alone or with at most two neighbours, is an outlier if its value is far from the values
before it and after it. In addition, no similar deviation may occur at the same angle in other
revolutions. Real deviations differ from outliers: after a lost count the deviation stays, a scratch
recurs at its angle in both heads, and a vibration continues.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from arctrue.workbench.numeric.distributions import student_limit

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Boolean = NDArray[np.bool_]

FAR_SIGMA = 6.0
"""Smallest distance of an outlier, in standard deviations: normal noise of known σ exceeds it once
in 5·10⁸ rows."""
FALSE_ROWS = 0.02
"""Largest mean number of rows of a channel that are beyond the limit of an outlier in white normal
noise, whatever the number of rows."""
MAD_EFFICIENCY = 0.37
"""Efficiency of the median absolute deviation relative to the standard deviation (Rousseeuw and
Croux, J. Am. Stat. Assoc. 88 (1993) 1273): n rows give 0.37·n degrees of freedom."""
NEAR_SIGMA = 3.0
"""Largest deviation, in standard deviations, of the rows next to an outlier, and of the rows at the
same angle in other revolutions."""
MOST_ROWS = 3
"""Largest number of neighbouring outliers; a longer deviation may be real."""
SIDE_ROWS = 2 * MOST_ROWS + 1
"""Number of rows in the median on each side of a row; outliers are always a minority of these
rows."""
LEAST_SIDE_ROWS = 5
"""Smallest number of rows in the median on a side near an end; two wrong rows change this median
only a little."""
OF_A_STEP = 0.5
"""A row belongs to one side of a step if its distance from the rows on that side is at most this
share of its distance from the rows on both sides. An outlier has about the same distance from both
sides. Half of that distance is at least NEAR_SIGMA, because an outlier is FAR_SIGMA away."""
TO_MIDDLE = SIDE_ROWS // 2 + 1
"""Distance, in rows, to the middle of the SIDE_ROWS rows before or after a row."""
LEAST_ROWS = 3 * SIDE_ROWS
"""Smallest number of rows of a run, or of a pass with closely spaced rows, in which a single wrong
row can be recognised."""
SCALE_ROWS = 256
"""Number of rows from which one value of the local scatter is calculated."""
END_ROWS = 4 * SCALE_ROWS
"""Number of rows at each end of a run that show how accurately one side predicts a row."""
WAVE_ORDERS = 20
"""Number of orders, as in the paper's model, that are subtracted before rows on both sides of a gap
are compared."""
WAVE_CONDITION = 1e-6
"""The fit of the wave sets singular values below this share of the largest one to zero, because the
rows of an arc cannot separate all orders."""
MOST_FITTED = 20_000
"""The wave of a longer run is fitted to evenly spread rows; their number is at least this value and
less than twice this value."""
MOST_SHARE = 0.05
"""Largest share of outliers; with a larger share the recording is faulty."""
NORMAL_MAD = 1.4826
"""Standard deviation of normal noise divided by its median absolute deviation."""
LEAST_VISITS = 4
"""Smallest number of readings of a station among which a single wrong reading can be recognised."""
LEAST_PASS_ROWS = 3
"""Smallest number of rows of a pass in which a single wrong reading can be recognised: two other
rows then agree with each other."""
SAME_PLACE_ROWS = 1.5
"""Largest distance, in steps between rows, of rows in different revolutions that count as the same
angle."""
MOST_COMPARED = 20_000
"""Largest number of outliers that are compared with other revolutions; if there are more, all of
them count as wrong rows."""


def far_threshold(rows: int, scatter_rows: float) -> float:
    """Return the smallest distance of an outlier among ``rows`` rows, in standard deviations, at
    least FAR_SIGMA.

    If the scatter is estimated from ``scatter_rows`` rows, a normal row has Student's t
    distribution: the mean number of normal rows beyond the threshold, on both sides together, is
    then FALSE_ROWS.
    """
    freedom = max(MAD_EFFICIENCY * scatter_rows, 1.0)
    return max(FAR_SIGMA, student_limit(0.5 * FALSE_ROWS / max(rows, 1), freedom))


def local_scatter(away: Float, resolution: float) -> Float:
    """Return the robust standard deviation around each row, (rows,), at least the standard
    deviation of all rows.

    The result is the largest scatter of a stretch of SCALE_ROWS rows and its two neighbour
    stretches, so that rows with larger noise over a part of the turn are no outliers. Values with
    steps of ``resolution`` show no scatter below half a step.
    """
    half = 0.5 * resolution
    overall = NORMAL_MAD * max(float(middle(np.abs(away))), half)
    blocks = away.size // SCALE_ROWS
    if blocks < 3:
        return np.full(away.size, overall)
    whole = np.abs(away[: blocks * SCALE_ROWS]).reshape(blocks, SCALE_ROWS)
    each = NORMAL_MAD * np.maximum(middle(whole), half)
    padded = np.concatenate([each[:1], each, each[-1:]])
    largest = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
    scatter = np.repeat(largest, SCALE_ROWS)
    tail = np.full(away.size - scatter.size, largest[-1])
    return np.asarray(np.maximum(np.concatenate([scatter, tail]), overall))


def middle(values: Float) -> Float:
    """Return the mean of the middle fifth along the last axis, (…, rows) → (…).

    This mean replaces a median, which has steps: the median of rounded values is a rounded value,
    or half-way between two.
    """
    last = values.shape[-1] - 1
    low, high = int(np.floor(0.4 * last)), int(np.ceil(0.6 * last))
    return np.asarray(np.partition(values, (low, high), axis=-1)[..., low : high + 1].mean(axis=-1))


def lonely(away: Float, scatter: Float, threshold: float = FAR_SIGMA) -> Boolean:
    """Return True where up to MOST_ROWS consecutive rows are far off and the rows next to these
    rows are not.

    ``away``: distance of each row from the rows around it; ``scatter``: standard deviation of that
    distance. Shapes (rows,). ``threshold``: smallest distance that is far, in standard deviations,
    see :func:`far_threshold`.
    """
    found = np.zeros(away.size, dtype=bool)
    size = np.abs(away)
    far = np.flatnonzero(size > threshold * scatter)
    if far.size == 0:
        return found
    off = size > NEAR_SIGMA * scatter
    breaks = np.flatnonzero(np.diff(far) > 1) + 1
    for group in np.split(far, breaks):
        first, last = int(group[0]), int(group[-1])
        while first > 0 and off[first - 1] and last - first < MOST_ROWS:
            first -= 1
        while last < away.size - 1 and off[last + 1] and last - first < MOST_ROWS:
            last += 1
        if last - first < MOST_ROWS:
            found[group] = True
    return found


def from_both_sides(values: Float) -> Float:
    """Predict the value of each row from the rows before and after it, (rows,).

    The prediction is the mean of two medians, of the SIDE_ROWS rows before and of the SIDE_ROWS
    rows after the row: exact where the values rise evenly, and unaffected by MOST_ROWS wrong rows
    on each side. Near an end, all rows up to the end are used, and the same number of rows on the
    other side. For the first and the last LEAST_SIDE_ROWS rows the prediction is not-a-number;
    :func:`from_one_side` predicts these rows.
    """
    medians = median_filter(values, size=SIDE_ROWS, mode="nearest")
    expected = np.full(values.size, np.nan)
    inner = np.arange(SIDE_ROWS, values.size - SIDE_ROWS)
    expected[inner] = 0.5 * (medians[inner - TO_MIDDLE] + medians[inner + TO_MIDDLE])
    for side in range(LEAST_SIDE_ROWS, min(SIDE_ROWS, values.size // 2)):
        for part, row in (
            (values[: 2 * side + 1], side),
            (values[-2 * side - 1 :], values.size - 1 - side),
        ):
            expected[row] = 0.5 * (np.median(part[:side]) + np.median(part[side + 1 :]))
    return expected


def from_one_side(values: Float) -> Float:
    """Predict the value of each row from the rows after it.

    The prediction is on the straight line through two medians, of the next SIDE_ROWS rows and of
    the SIDE_ROWS rows after these; MOST_ROWS rows of each may be wrong. At the last 2·SIDE_ROWS
    rows the prediction is not-a-number.
    """
    medians = median_filter(values, size=SIDE_ROWS, mode="nearest")
    expected = np.full(values.size, np.nan)
    first = np.arange(values.size - 2 * SIDE_ROWS)
    near, far = medians[first + TO_MIDDLE], medians[first + TO_MIDDLE + SIDE_ROWS]
    expected[first] = near + (near - far) * (TO_MIDDLE / SIDE_ROWS)
    return expected


def far_from_neighbours(
    values: Float, least: float, resolution: float = 0.0, pieces: Sequence[slice] = ()
) -> tuple[Float, Float]:
    """Return the distance of each row from the rows around it, and the standard deviation of that
    distance, at least ``least``.

    ``values``: rows of one run or pass in order, (rows,), in steps of ``resolution``. ``pieces``:
    parts of at least LEAST_ROWS rows, between which rows are missing; if empty, all rows are one
    piece.

    The first and last LEAST_SIDE_ROWS rows of a piece have neighbours on one side only, which
    predict them. The standard deviation of their distance is calculated from the same one-sided
    prediction over the END_ROWS rows at that end; it is larger than for a prediction from both
    sides.
    """
    away = np.full(values.size, np.nan)
    after, before = away.copy(), away.copy()
    for piece in pieces or [slice(0, values.size)]:
        own = values[piece]
        away[piece] = own - from_both_sides(own)
        first, last = own[:END_ROWS], own[-END_ROWS:]
        after[piece][: first.size] = first - from_one_side(first)
        before[piece][-last.size :] = last - from_one_side(last[::-1])[::-1]
    scatter = _scatter_of_all(away, resolution)
    for one_sided in (after, before):
        end = np.isnan(away) & ~np.isnan(one_sided)
        scatter[end] = np.maximum(scatter, _scatter_of_all(one_sided, resolution))[end]
        away[end] = one_sided[end]
    return away, np.maximum(scatter, least)


def _scatter_of_all(away: Float, resolution: float) -> Float:
    """Return the local scatter at each row, from the rows whose distance is known."""
    known = ~np.isnan(away)
    place = np.cumsum(known) - 1
    return np.asarray(local_scatter(away[known], resolution)[np.maximum(place, 0)])


def gaps(angle: Float) -> Integer:
    """Return the numbers of the steps over missing rows in a run; ``angle``: (rows,).

    Step k leads from row k to row k + 1. A step over missing rows is larger than SIDE_ROWS times
    the mean step of the run and than SIDE_ROWS times the median step around it, so that a changing
    speed causes no gap.
    """
    step = np.abs(np.diff(angle))
    long = np.flatnonzero(step > SIDE_ROWS * float(np.mean(step))) if step.size else step
    found = []
    for place in long.astype(np.int64).tolist():
        around = step[max(place - SIDE_ROWS, 0) : place + SIDE_ROWS + 1]
        if step[place] > SIDE_ROWS * float(np.median(around)):
            found.append(place)
    return np.array(found, dtype=np.int64)


def pieces_between_gaps(angle: Float) -> list[slice]:
    """Return the pieces of a run between gaps, LEAST_ROWS or more each; ``angle``: (rows,).

    A piece of fewer rows than LEAST_ROWS is joined to its neighbour.
    """
    cuts = [0]
    for place in gaps(angle).tolist():
        first = place + 1
        if first - cuts[-1] >= LEAST_ROWS and angle.size - first >= LEAST_ROWS:
            cuts.append(first)
    return [slice(start, end) for start, end in pairwise([*cuts, angle.size])]


def without_wave(values: Float, angle_rad: Float) -> Float:
    """Subtract the mean and the first WAVE_ORDERS orders of the turn, if there are gaps; (rows,).

    The wave is fitted to running medians; short runs have fewer orders. The values on both sides of
    a gap then agree, so that the few rows between two gaps are not far from the rows beyond the
    gaps. Values without gaps are not changed.
    """
    if gaps(angle_rad).size == 0:
        return values
    thin = slice(None, None, max(values.size // MOST_FITTED, 1))
    medians = median_filter(values, size=SIDE_ROWS, mode="nearest")[thin]
    orders = np.arange(1, min(WAVE_ORDERS, values.size // (4 * SIDE_ROWS)) + 1)
    phase = np.outer(angle_rad[thin], orders)
    columns = np.column_stack([np.ones(medians.size), np.cos(phase), np.sin(phase)])
    found = np.linalg.lstsq(columns, medians, rcond=WAVE_CONDITION)[0]
    flat = values - found[0]
    for order, even, odd in zip(orders, *np.split(found[1:], 2), strict=True):
        flat -= even * np.cos(order * angle_rad) + odd * np.sin(order * angle_rad)
    return np.asarray(flat)


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
    place = np.mod(angle_rad, 2.0 * np.pi)
    order = np.argsort(place, kind="stable")
    sorted_place = place[order]
    step = float(np.median(np.abs(np.diff(angle_rad)))) if angle_rad.size > 1 else 0.0
    for number, row in enumerate(rows.tolist()):
        reach = SAME_PLACE_ROWS * step
        first = np.searchsorted(sorted_place, place[row] - reach)
        last = np.searchsorted(sorted_place, place[row] + reach, side="right")
        there = order[first:last]
        there = there[revolution[there] != revolution[row]]
        if there.size == 0:
            continue
        same_sense = np.sign(away[row]) * away[there] / scatter[there]
        found[number] = _in_most_revolutions(same_sense, revolution[there]) > NEAR_SIGMA
    return found


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
    by chance in one of a dozen turns.
    """
    found = np.zeros(rows.size, dtype=bool)
    if rows.size == 0 or rows.size > MOST_COMPARED:
        return found
    place = np.mod(angle_rad, 2.0 * np.pi)
    order = np.argsort(place, kind="stable")
    sorted_place = place[order]
    step = float(np.median(np.abs(np.diff(angle_rad)))) if angle_rad.size > 1 else 0.0
    for number, row in enumerate(rows.tolist()):
        for shift in (separation_rad, -separation_rad):
            at = np.mod(place[row] + shift, 2.0 * np.pi)
            first = np.searchsorted(sorted_place, at - SAME_PLACE_ROWS * step)
            last = np.searchsorted(sorted_place, at + SAME_PLACE_ROWS * step, side="right")
            there = order[first:last]
            if there.size:
                opposite = -np.sign(away[row]) * away[there] / scatter[there]
                found[number] |= _in_most_revolutions(opposite, revolution[there]) > FAR_SIGMA
    return found


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
            alike = np.sign(away[row]) * away[there]
            found[number] = float(np.median(alike)) > NEAR_SIGMA * scatter
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
