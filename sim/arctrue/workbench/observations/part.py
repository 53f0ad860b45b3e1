"""Selects the part of a long capture or reference that searches and statistics use.

The part consists of stretches spread over every run. A stretch of a capture has two turns if the
run is long enough; from turns of many rows, only every second, third, … row is kept. A stretch of a
reference has 2,048 to 4,095 rows, or fewer in a short run. The part therefore contains the
electrical phases, the turn-to-turn scatter and the conditions of every run. An error that 150,000
rows of 0.2″ noise cannot show is smaller than 0.002″, far below the smallest error that matters
(half a count RMS, 0.039″).
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.workbench.observations.rows import CaptureRows, ReferenceRows
from arctrue.workbench.observations.stored import StoredCapture

MOST_ROWS = 150_000
"""Largest number of rows of a capture, or of a reference, that is used as a whole."""
REFERENCE_STRETCH_ROWS = 2048
"""Smallest number of rows in a stretch of a reference, except in a short run: 42 cycles, up and
down, of a polygon with 24 faces."""
LEAST_ROWS_A_RUN = 256
"""Smallest number of rows that the part keeps of every run, so that the run's offset and conditions
stay in the statistics."""
STRETCH_TURNS = 2
"""Number of turns in one stretch: the second turn repeats the first."""
LEAST_ROWS_A_TURN = 12_000
"""Smallest number of rows of a turn after thinning, which keeps every second, third, … row; this
number equals the number in the paper."""
SEED = 20_120_215
"""Seed of the random positions of the stretches, fixed so that a set always gives the same part."""


def part_of(stored: StoredCapture) -> tuple[CaptureRows, StoredCapture | None]:
    """Return the rows in use and, if they are a part of the capture, all its rows (else None)."""
    if stored.size <= MOST_ROWS:
        return stored.rows(slice(None)), None
    return stored.rows(kept_rows(stored, MOST_ROWS)), stored


def part_of_reference(rows: ReferenceRows) -> tuple[ReferenceRows, ReferenceRows | None]:
    """Return the rows in use and, if they are a part of the reference, all its rows (else None)."""
    if rows.run.size <= MOST_ROWS:
        return rows, None
    numbered = replace(rows, row=np.arange(rows.run.size))
    random = np.random.default_rng(SEED)
    kept = np.zeros(rows.run.size, dtype=bool)
    for start, end in run_spans(rows.run):
        size = end - start
        share = max(LEAST_ROWS_A_RUN, round(MOST_ROWS * size / rows.run.size))
        pieces = max(share // REFERENCE_STRETCH_ROWS, 1)
        length = min(share // pieces, size)
        # Each of the equal shares of the run has a stretch at a random place, since an even spacing
        # would alias.
        edges = np.linspace(start, end, pieces + 1).astype(int)
        for low, high in pairwise(edges.tolist()):
            first = low + int(random.integers(max(high - low - length, 0) + 1))
            kept[first : min(first + length, high)] = True
    return numbered.part(kept), numbered


def kept_rows(stored: StoredCapture, most_rows: int) -> NDArray[np.int64]:
    """Return the numbers of the rows that the part keeps, ascending; it keeps rows of every run."""
    random = np.random.default_rng(SEED)
    pieces = []
    for start, end in stored.run_spans():
        share = max(LEAST_ROWS_A_RUN, round(most_rows * (end - start) / stored.size))
        pieces += [
            np.arange(first, last, step)
            for first, last, step in _stretches(stored.revolution[start:end], start, share, random)
        ]
    return np.concatenate(pieces)


def _stretches(
    revolution: NDArray[np.int32], start: int, share: int, random: np.random.Generator
) -> list[tuple[int, int, int]]:
    """Return first row, row after the last and step of each stretch that is kept in one run."""
    size = revolution.size
    if size <= share:
        return [(start, start + size, 1)]
    bounds = [0, *(np.flatnonzero(np.diff(revolution)) + 1).tolist(), size]
    turns = list(pairwise(bounds))
    rows_a_turn = float(np.median([last - first for first, last in turns]))
    most_step = max(int(rows_a_turn / LEAST_ROWS_A_TURN), 1)
    wanted_step = -(-STRETCH_TURNS * rows_a_turn // share)
    step = int(min(max(wanted_step, 1), most_step))
    count = int(share / (STRETCH_TURNS * rows_a_turn / step))
    if count < 1 or len(turns) < STRETCH_TURNS:
        first = int(random.integers(size - (share - 1) * step)) if size > share * step else 0
        return [(start + first, start + min(first + share * step, size), step)]
    # Each of the equal shares of the run has a stretch at a random place, since an even spacing
    # would alias.
    edges = np.linspace(0, len(turns), count + 1).astype(int)
    found = []
    for low, high in pairwise(edges.tolist()):
        room = max(high - low - STRETCH_TURNS, 0)
        first = low + int(random.integers(room + 1))
        last = min(first + STRETCH_TURNS, high)
        found.append((start + turns[first][0], start + turns[last - 1][1], step))
    return found
