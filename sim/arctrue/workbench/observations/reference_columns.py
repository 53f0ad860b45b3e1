"""Finds columns of a reference that contradict each other, or that keep one value while the table
moves."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.base.percent import percent
from arctrue.workbench.observations.different_stations import stations_of
from arctrue.workbench.observations.file_lines import file_line
from arctrue.workbench.observations.reference_speed import MOVING_STEP_DEG, continued
from arctrue.workbench.observations.rows import ReferenceRows

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Boolean = NDArray[np.bool_]

LEAST_STEPS = 20
"""Smallest number of steps of a pass whose direction is examined, and smallest number of equal rows
that are a fault: fewer rows do not change a result."""
LEAST_RANGE_DEG = 1.0
"""Smallest range of the targets of a pass whose direction is examined: a table that stands has no
direction, and the noise of its angle is smaller."""
MOST_AGAINST = 0.2
"""Largest share of steps that are among two or more successive steps against the direction. A
return to the first station is a single step; in random values, 7/24 of the steps are among such
steps."""
LEAST_WAY = 0.5
"""Smallest travel of a pass in its direction, relative to the range of its targets: noisy targets
have steps against the direction, but their pass leads from one end of the range to the other."""
FOLLOWS = 0.95
"""Smallest share of steps of the errors in the direction at which the columns seem to be exchanged:
an angle in motion follows the direction in nearly every step."""
LONG_WAY = 10.0
"""Smallest range of the targets, relative to their median step, at which the columns seem to be
exchanged. Stations in random order have a range of 2/(2 − √2) = 3.4 median steps, white noise of a
thousand rows about 7."""
MOST_EQUAL = 0.5
"""Equal errors show that the sensor stands still only if at most this share of the other rows
equals the row before. With a larger share, the display is coarser than the changes of the error."""
LONGER = 10.0
"""Smallest length of the equal rows that are a fault, relative to the next longest equal rows.
Rounded values of a smooth curve keep one value at most five times as long at an extremum as next to
it: the ratio is 2/(√2 − 1) = 4.8 for a parabola."""
LEAST_SHARE = 0.01
"""Equal rows are a fault only if they are at least this share of the rows of a reference."""
FALSE_P = 1e-6
"""Largest mean number of sequences of equal rows of this length by chance, from the share of equal
rows elsewhere."""


def direction_faults(rows: ReferenceRows, used: Integer | None) -> list[str]:
    """Describe the first pass whose direction its targets contradict; empty if there is none.

    ``used``: numbers in the file of the rows, None if all rows are used. Only rows in motion are
    examined, because a single station may be approached against the order of the stations. If the
    targets of all passes go against their directions, the column states the opposite sign of
    motion, which is accepted.
    """
    if rows.direction is None or rows.time_s is None:
        return []
    target = continued(np.degrees(rows.target_rad))
    passes = [(start, end) for start, end in _labelled(rows) if end - start > LEAST_STEPS]
    # Way of each pass in its direction, relative to the range of its targets.
    extents = [max(float(np.ptp(target[start:end])), 1e-12) for start, end in passes]
    ways = [
        float(np.sign(rows.direction[start])) * float(target[end - 1] - target[start]) / extent
        for (start, end), extent in zip(passes, extents, strict=True)
    ]
    sign = -1.0 if ways and max(ways) <= -LEAST_WAY else 1.0
    wrong: list[tuple[int, int, str]] = []
    for (start, end), extent, way in zip(passes, extents, ways, strict=True):
        own, sense = target[start:end], sign * float(np.sign(rows.direction[start]))
        against = _successive(np.diff(own) * sense < 0.0)
        if extent < LEAST_RANGE_DEG or float(against.mean()) <= MOST_AGAINST:
            continue
        step = float(np.median(np.abs(np.diff(own))))
        follows = float(np.mean(np.diff(rows.error_arcsec[start:end]) * sense > 0.0)) >= FOLLOWS
        follows &= extent > LONG_WAY * step
        if follows or (sign * way < LEAST_WAY and step <= MOVING_STEP_DEG):
            wrong.append(
                (
                    start + 1 + int(np.flatnonzero(against)[0]),
                    int(against.sum()),
                    "; error_arcsec follows the direction: are the columns target_deg and "
                    "error_arcsec exchanged?"
                    if follows
                    else "; check the columns direction and target_deg",
                )
            )
    if not wrong:
        return []
    first, _, advice = wrong[0]
    line = file_line(used, first)
    steps = sum(count for _, count, _ in wrong)
    return [
        f"reference, row {line - 2} of the data, line {line} of the file: "
        f"target_deg moves against the column direction, as in {steps} of {target.size - 1} steps; "
        f"expected steps in the direction{advice}"
    ]


def frozen_rows(rows: ReferenceRows, used: Integer | None) -> list[str]:
    """Describe the longest sequence of equal errors while the target moves, if it is longer than
    the equal rows elsewhere explain; empty if it is not."""
    error, size = rows.error_arcsec, rows.error_arcsec.size
    if size <= 2 * LEAST_STEPS:
        return []
    equal = (np.diff(error) == 0.0) & (np.diff(rows.run) == 0) & (np.diff(rows.target_rad) != 0.0)
    starts, lengths = _true_stretches(equal)
    if lengths.size == 0:
        return []
    longest = int(np.argmax(lengths))
    length, start = int(lengths[longest]), int(starts[longest])
    others = np.delete(lengths, longest)
    # Laplace's rule of succession: a share of 0 among n rows is not the probability 0.
    left = max(equal.size - length, 0)
    chance = (float(others.sum()) + 1.0) / (left + 2.0)
    if length < max(LEAST_STEPS, LEAST_SHARE * size) or left < LEAST_STEPS:
        return []
    if chance > MOST_EQUAL or length < LONGER * float(others.max(initial=0)):
        return []
    if size * chance**length > FALSE_P:
        return []
    line, last = file_line(used, start), file_line(used, start + length)
    return [
        f"reference, rows {line - 2} to {last - 2} of the data, from line {line} of the file: "
        f"error_arcsec has one value in {length + 1} successive "
        f"rows while target_deg moves; elsewhere {percent(float(others.sum()) / left)} of the rows "
        "equal the row before: the reference or its logger stood still; mask these rows (mask.csv)"
    ]


def saturated_rows(rows: ReferenceRows, used: Integer | None) -> list[str]:
    """Describe the rows with exactly the largest or the smallest error, at the limits of the
    instrument's range, if they are too many for an extremum; empty if they are not.

    At the extremum of a smooth curve, rounded values recur as well, but fewer than LONGER times as
    often as any other value. Rows of a single station do not count: they have the same value if
    each run is set to zero there, or while the table stands.
    """
    error, size = rows.error_arcsec, rows.error_arcsec.size
    values, count = np.unique(error, return_counts=True)
    if values.size <= LEAST_STEPS:
        return []
    usual = int(count[1:-1].max())
    least = max(LEAST_STEPS, LEAST_SHARE * size, LONGER * usual)
    ends = [
        (end, int(count[end]))
        for end in (-1, 0)
        if count[end] >= least
        and stations_of(np.degrees(rows.target_rad[error == values[end]])) > 1
    ]
    if not ends:
        return []
    first = int(np.flatnonzero(np.isin(error, values[[end for end, _ in ends]]))[0])
    said = " and ".join(
        f"its {'largest' if end else 'smallest'} value in {number} rows" for end, number in ends
    )
    return [
        f"reference, from line {file_line(used, first)} of the file: error_arcsec has exactly "
        f"{said}, {percent(sum(number for _, number in ends) / size)} of the rows; no other value "
        f"occurs in more than {usual}: the instrument is at the limit of its range; align it so "
        "that the error stays within its range, or mask these rows (mask.csv)"
    ]


def _labelled(rows: ReferenceRows) -> list[tuple[int, int]]:
    """Return first row and row after the last of each stretch with one run, cycle and direction."""
    new = np.diff(rows.run) != 0
    for labels in (rows.cycle, rows.direction):
        if labels is not None:
            new |= np.diff(labels) != 0
    return list(pairwise([0, *(np.flatnonzero(new) + 1).tolist(), rows.run.size]))


def _successive(found: Boolean) -> Boolean:
    """Return True where ``found`` is True and so is the value before or after; (steps,)."""
    before, after = np.append(False, found[:-1]), np.append(found[1:], False)
    return np.asarray(found & (before | after))


def _true_stretches(found: Boolean) -> tuple[Integer, Integer]:
    """Return the first index and the length of each stretch of True values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], found, [False]]).astype(np.int8)))
    return edges[::2], edges[1::2] - edges[::2]
