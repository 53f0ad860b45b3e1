"""Removes whole turns from errors, and continues counts that restart at each turn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.base.units import ARCSEC_PER_TURN

Integer = NDArray[np.int64]
Float = NDArray[np.float64]

ROUNDED_TURN = 1.0 + 1e-3
"""Largest range, in turns, of angles that restart at each turn: a display rounds the last angle of
a turn up, to 6.2832 rad or 360.0°."""
MOST_FOR_MEDIAN = 10_000
"""Number of rows of a long run from which a median is computed (up to twice as many). They suffice,
because the error of a reading is far below half a turn."""


def without_wraps(error_arcsec: Float) -> tuple[Float, Integer]:
    """Return errors (n,) without whole turns, and the indices of the rows that contained whole
    turns.

    An error is less than half a turn, so each error is moved by whole turns until it lies within
    half a turn of the median of all errors. The median is taken on the circle, because half of the
    rows may be wrong by a turn.
    """
    within = np.mod(error_arcsec, ARCSEC_PER_TURN) * (2.0 * np.pi / ARCSEC_PER_TURN)
    mean = float(np.angle(np.mean(np.exp(1j * within)))) * ARCSEC_PER_TURN / (2.0 * np.pi)
    # Errors are first moved to within half a turn of their circular mean, so that their median
    # exists; the median is robust against outliers.
    near = error_arcsec - ARCSEC_PER_TURN * np.round((error_arcsec - mean) / ARCSEC_PER_TURN)
    usual = float(np.median(near))
    usual -= ARCSEC_PER_TURN * np.round(usual / ARCSEC_PER_TURN)
    turns = np.round((error_arcsec - usual) / ARCSEC_PER_TURN)
    wrapped = np.flatnonzero(turns)
    return error_arcsec - ARCSEC_PER_TURN * turns if wrapped.size else error_arcsec, wrapped


def unwrapped_counts(
    counts: Integer, run: Integer, time_s: Float, counts_per_rev: int
) -> tuple[Integer, int]:
    """Return counts (n,) that continue past the turn, and the number of restarts.

    Counts are changed only if all of them lie within one turn (rounded) and some step is longer
    than half a turn. Such a step is replaced by the step that agrees best with the run's usual
    speed and the elapsed time.
    """
    largest = ROUNDED_TURN * counts_per_rev
    if counts.size < 3 or int(counts.min()) < 0 or int(counts.max()) > largest:
        return counts, 0
    found = counts.copy()
    wraps = 0
    for start, end in run_spans(run):
        step = np.diff(counts[start:end])
        if step.size == 0 or int(np.abs(step).max()) <= counts_per_rev // 2:
            continue
        passed = np.diff(time_s[start:end])
        short = (np.abs(step) <= counts_per_rev // 2) & (passed > 0.0)
        if not short.any():
            continue
        usual = float(np.median(step[short] / passed[short]))
        turns = np.round((usual * passed - step) / counts_per_rev).astype(np.int64)
        turns[np.abs(step) <= counts_per_rev // 2] = 0
        wraps += int(np.count_nonzero(turns))
        found[start + 1 : end] += np.cumsum(turns) * counts_per_rev
    return found, wraps


def same_turn(
    head1_counts: Integer,
    other_counts: Integer,
    run: Integer,
    counts_per_rev: int,
    place_deg: float,
) -> Integer:
    """Shift each run of another head's counts (n,) by whole turns.

    Afterwards the median of these counts is within half a turn of the counts of head 1 plus this
    head's place. If no run needs a shift, the result is ``other_counts`` itself.
    """
    apart = round(place_deg / 360.0 * counts_per_rev)
    found = other_counts
    for start, end in run_spans(run):
        some = slice(start, end, max((end - start) // MOST_FOR_MEDIAN, 1))
        away = float(np.median(other_counts[some] - head1_counts[some])) - apart
        turns = round(away / counts_per_rev)
        if turns:
            found = other_counts.copy() if found is other_counts else found
            found[start:end] -= turns * counts_per_rev
    return found
