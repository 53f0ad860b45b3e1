"""Finds the instants at which a head's count changes, which are the edges of its A, B and Z
wires."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.cause import SIGNALS, refuse_unhonoured
from arctrue.table.crossings import level_crossings, solve_brackets
from arctrue.table.motion import Motion
from arctrue.table.rotary_table import RotaryTable
from arctrue.table.state import TableState

TOLERANCE_COUNTS = 1e-7
"""Tolerance of the position of an edge, counts. For a turn of 2^24 counts float64 resolves 4e-9
counts."""


@dataclass(frozen=True, slots=True)
class CountEdges:
    """Count edges of one head in order of time, in arrays ``(n,)``."""

    first_count: int
    """Count before the first edge."""
    time_s: NDArray[np.float64]
    """Time of each edge since the motion began, seconds."""
    count: NDArray[np.int64]
    """Count after each edge, from the head's index, not wrapped."""
    true_angle_rad: NDArray[np.float64]
    """True angle of the table at each edge, radians."""


def count_edges(
    table: RotaryTable,
    head: int,
    motion: Motion,
    random: np.random.Generator | None = None,
) -> CountEdges:
    """Return time and true angle of every count edge of a head during a motion.

    The interpolator has a hysteresis, so that an edge does not pass its neighbours and noise never
    adds a pair of edges.

    Parameters
    ----------
    table : RotaryTable
        The table.
    head : int
        Number of the head, from 0.
    motion : Motion
        The motion; all edges from its beginning to its end are found.
    random : numpy.random.Generator, optional
        Source of the noise of the readings, which displaces each edge; None: no noise.

    Returns
    -------
    CountEdges
        All edges in order of time.

    Raises
    ------
    UnhonouredCauseError
        If a cause acts on a quantity that the edges do not show, for example on the counter (lost
        counts) or on the reference instrument.
    """

    refuse_unhonoured(table.causes, SIGNALS, "a head's edges")

    def reading(time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        return table.reading_rad(head, motion.state(time_s)) / table.count_rad

    offset = -0.5 if table.rounding == "nearest" else 0.0
    grid = _time_grid(motion)
    time_s, level, step = level_crossings(reading, grid, offset, tolerance=TOLERANCE_COUNTS)
    first = int(table.round_counts(reading(grid[:1]))[0])
    count = level - (step < 0)
    if random is not None and table.noise_rad and time_s.size:
        time_s = _displaced(table, motion, time_s, random)
    return CountEdges(first, time_s, count, motion.state(time_s).angle_rad)


def _time_grid(motion: Motion) -> NDArray[np.float64]:
    # The grid has 256 intervals a turn of travel and at least 64 between two bends of the profile.
    # An interval is short against a period of a ripple with some tens of periods a turn, so the
    # reading is monotonic in each interval.
    bends = motion.turning_times_s()
    parts = []
    for begin, end in itertools.pairwise(bends.tolist()):
        ends = motion.state(np.array([begin, end])).angle_rad
        turns = abs(ends[1] - ends[0]) / (2 * np.pi)
        parts.append(np.linspace(begin, end, 65 + int(256 * turns))[:-1])
    return np.concatenate([*parts, bends[-1:]])


def _displaced(
    table: RotaryTable,
    motion: Motion,
    time_s: NDArray[np.float64],
    random: np.random.Generator,
) -> NDArray[np.float64]:
    # Noise shifts the level that the reading crosses; to first order this delays the edge by noise
    # / speed. Noise is far below a count, and the speed hardly changes within a count.
    speed = np.abs(motion.state(time_s).speed_rad_s)
    slowest = np.maximum(speed, 1e-3 * speed.max())
    shifted = time_s + random.normal(0.0, table.noise_rad, time_s.shape) / slowest
    return np.clip(np.maximum.accumulate(shifted), 0.0, motion.duration_s)


def angle_of_reading(
    table: RotaryTable, head: int, reading_counts: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the true angle at which the table, turning slowly, shows each reading.

    The causes of the table must not depend on time or speed.

    Parameters
    ----------
    table : RotaryTable
        The table.
    head : int
        Number of the head, from 0.
    reading_counts : ndarray
        Readings from the head's index, counts, shape (n,).

    Returns
    -------
    ndarray
        True angles, not wrapped, radians, shape (n,).

    Raises
    ------
    ArithmeticError
        If the error of the reading exceeds a tenth of a turn.
    """
    nominal = reading_counts * table.count_rad + table.heads[head].angle_rad
    nominal = nominal + table.index_mark_rad

    def reading(angle_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        return table.reading_rad(head, TableState.at_rest(angle_rad)) / table.count_rad

    tenth = 2 * np.pi / 10
    return solve_brackets(
        reading, nominal - tenth, nominal + tenth, reading_counts, tolerance=TOLERANCE_COUNTS
    )
