"""Sorts the rows of a reference into cells: one place in one pass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.design_matrix import channel_columns
from arctrue.workbench.inference.same_place import Visits, cell_means
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.observations.rows import ReferenceRows

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

STATION_RAD = 1e-4
"""Largest angle within one station, 20″: the lack of fit by stations has the same limit."""
PLACES_A_TURN = 720
"""Largest number of places of a log in motion, 0.5° each: 36 in a period of the paper's 20th order.
"""
WIDEST_STEP_RAD = 2.0 * np.pi / 180.0
"""Largest median step of rows that are averaged over places of two steps: 4.5 places in a period of
the 20th order. Stations that are farther apart must be equal in each pass."""
LEAST_PLACES = 8
"""Smallest number of places of a pass: three degrees of freedom then remain after a mean and two
orders."""
LEAST_LEFT = 8
"""The model's columns are removed from the passes only if each pass keeps at least this number of
degrees of freedom; with fewer, only the mean is removed. Two passes with eight degrees of freedom
coincide by chance with a correlation above 0.9 in one of 2,000 cases."""
RANK = 1e-6
"""Smallest ratio of a singular value to the largest one: angles are known to 10⁻⁶ rad."""


def visits_of_rows(rows: ReferenceRows) -> Visits | None:
    """Return the visits of the places within the turn, without residuals; None if no second pass
    repeats the places of a pass."""
    size = rows.run.size
    return _visits(rows, np.zeros(size), np.zeros((size, 0)), None, over_travel=False)


def visits_beyond_low_orders(
    rows: ReferenceRows, orders: int, noise: RowNoise | None
) -> tuple[Visits, int] | None:
    """Return the visits of the stations of a whole turn after a curve of the orders 1 to n is
    removed, and n, the largest order with which each pass keeps LEAST_LEFT degrees of freedom.

    ``orders``: number of orders of the model. Returns None if it is not larger than n, if n would
    be 0, or if the stations do not cover the turn.
    """
    usual = visits_of_rows(rows)
    if usual is None or not usual.stations or usual.angle_rad.size < 2:
        return None
    fewest = min(inside.size for inside, _ in usual.bases)
    low = (fewest - 1 - LEAST_LEFT) // 2
    gap = float(np.max(np.diff(usual.angle_rad, append=usual.angle_rad[0] + 2.0 * np.pi)))
    if low < 1 or low >= orders or gap * low > np.pi:
        return None
    numbers = np.arange(1, low + 1)
    phase = rows.target_rad[:, np.newaxis] * numbers
    columns = np.concatenate([np.cos(phase), np.sin(phase)], axis=1)
    found = _visits(rows, rows.error_arcsec, columns, noise, over_travel=False)
    return None if found is None else (found, low)


def visits_of(solution: Solution) -> Visits | None:
    """Return the visits of the places of a reference; None if no second pass repeats its places.

    A log of several turns may repeat its error in each turn, or only at the same angle of travel;
    the case in which the passes agree better is chosen, and its p counts both.
    """
    rows, left = solution.observations.reference, solution.reference_residual_arcsec()
    if rows is None or left is None or "reference" in solution.unknown_noise:
        return None
    columns = channel_columns(
        solution.terms, solution.observations, solution.context, capture=False
    )
    noise = solution.noise.reference
    within_a_turn = _visits(rows, left, columns, noise, over_travel=False)
    if float(np.ptp(rows.target_rad)) < 4.0 * np.pi:
        return within_a_turn
    over_travel = _visits(rows, left, columns, noise, over_travel=True)
    both = [item for item in (within_a_turn, over_travel) if item is not None]
    found = [replace(item, cases=len(both)) for item in both]
    return min(found, key=lambda item: item.by_place.p, default=None)


def _visits(
    rows: ReferenceRows, left: Float, columns: Float, noise: RowNoise | None, *, over_travel: bool
) -> Visits | None:
    turn = 2.0 * np.pi
    angle = rows.target_rad if over_travel else np.mod(rows.target_rad, turn)
    width, stations = _width(rows.target_rad, angle)
    if width is None:
        return None
    place = np.round(angle / width).astype(np.int64)
    aside = angle - place * width
    if not over_travel:
        place %= max(round(turn / width), 1)
    one_pass = _passes(rows, place, over_travel=over_travel)
    kept = np.ones(place.size, dtype=np.bool_)
    for _ in range(3):
        # A place needs two passes, and a pass LEAST_PLACES places.
        cells = np.unique(np.stack([one_pass[kept], place[kept]]), axis=1)
        names, passes = np.unique(cells[1], return_counts=True)
        again = np.isin(place, names[passes > 1])
        names, places = np.unique(cells[0], return_counts=True)
        kept &= again & np.isin(one_pass, names[places >= LEAST_PLACES])
    if not kept.any() or np.unique(one_pass[kept]).size < 2:
        return None
    of_row = np.full(place.size, -1, dtype=np.int64)
    cells, inverse = np.unique(np.stack([one_pass[kept], place[kept]]), axis=1, return_inverse=True)
    of_row[kept] = np.asarray(inverse).reshape(-1)
    size = cells.shape[1]
    names, place_of = np.unique(cells[1], return_inverse=True)
    place_of = np.asarray(place_of).reshape(-1)
    _, pass_of = np.unique(cells[0], return_inverse=True)
    aside_of_place = np.bincount(place_of, cell_means(of_row, aside, size)) / np.bincount(place_of)
    side = np.zeros(size)
    if rows.direction is not None:
        side = np.sign(cell_means(of_row, rows.direction, size))
    found = (
        np.stack([cell_means(of_row, column, size) for column in columns.T], axis=1)
        if (columns.shape[1])
        else np.zeros((size, 0))
    )
    bases = _bases(found, np.asarray(pass_of).reshape(-1))
    visits = Visits(
        of_row,
        place_of,
        np.asarray(pass_of).reshape(-1),
        names * width + aside_of_place,
        bases,
        np.zeros(0),
        stations,
        over_travel,
        side.astype(np.int64),
        float(np.mean(left**2)),
        noise,
        _crossed(rows, np.where(of_row >= 0, place_of[of_row], -1), names.size),
    )
    return replace(visits, left=visits.means(left))


def _crossed(rows: ReferenceRows, place: Integer, places: int) -> NDArray[np.bool_]:
    """Return True for each place from which a run goes on to the next place of the turn, or back;
    ``place``: number of the place of each row, −1 without one."""
    found = np.zeros(places, dtype=np.bool_)
    before, after = place[:-1], place[1:]
    same = (np.diff(rows.run) == 0) & (before >= 0) & (after >= 0)
    same &= np.abs(np.diff(rows.target_rad)) < np.pi
    found[before[same & ((after - before) % places == 1)]] = True
    found[after[same & ((before - after) % places == 1)]] = True
    return found


def _width(target: Float, angle: Float) -> tuple[float | None, bool]:
    """Return the width of a place, and whether the places are stations that are equal in each
    pass; no width if the rows are too far apart to be averaged."""
    stations = np.unique(np.round(angle / STATION_RAD)).size
    steps = np.abs(np.diff(target))
    moved = steps[steps > STATION_RAD]
    if moved.size == 0:
        return None, True
    step = float(np.median(moved))
    places = float(np.ptp(angle)) / (2.0 * np.pi) * PLACES_A_TURN
    if 2 * stations <= angle.size and stations <= max(places, PLACES_A_TURN):
        return STATION_RAD, True
    if step > WIDEST_STEP_RAD:
        return None, False
    # The turn is a whole number of places, so that equal angles of all turns share a place.
    turns = max(np.ptp(angle) / (2.0 * np.pi) if np.ptp(angle) > 2.0 * np.pi else 1.0, 1.0)
    width = max(2.0 * step, 2.0 * np.pi * turns / PLACES_A_TURN)
    return 2.0 * np.pi / max(np.floor(2.0 * np.pi / width), 1.0), False


def _passes(rows: ReferenceRows, place: Integer, *, over_travel: bool) -> Integer:
    """Return the number of the pass of each row: a new pass starts with another run, cycle or
    direction, and where a place of the pass is visited again after other places."""
    change = np.zeros(place.size, dtype=np.bool_)
    for column in (rows.run, rows.cycle, rows.direction):
        if column is not None:
            change[1:] |= np.diff(column) != 0
    if not over_travel:
        change[1:] |= np.diff(np.floor(rows.target_rad / (2.0 * np.pi) + 1e-9)) != 0
    found = np.zeros(place.size, dtype=np.int64)
    seen: set[int] = set()
    number, last = 0, -1
    for row, (one, new) in enumerate(zip(place.tolist(), change.tolist(), strict=True)):
        if new or (one != last and one in seen):
            number += 1
            seen.clear()
        seen.add(one)
        found[row] = number
        last = one
    return found


def _bases(columns: Float, one_pass: Integer) -> tuple[tuple[Integer, Float], ...]:
    """Return the cells of each pass with an orthonormal basis of the constant and the model's
    columns; of the constant alone if a pass has too few places for these columns."""
    inside = [np.flatnonzero(one_pass == number) for number in range(int(one_pass.max()) + 1)]
    full = []
    for at in inside:
        vectors, values, _ = np.linalg.svd(
            np.column_stack([np.ones(at.size), columns[at]]), full_matrices=False
        )
        full.append(vectors[:, values > RANK * values[0]])
    if any(at.size - basis.shape[1] < LEAST_LEFT for at, basis in zip(inside, full, strict=True)):
        full = [np.full((at.size, 1), at.size**-0.5) for at in inside]
    return tuple(zip(inside, full, strict=True))
