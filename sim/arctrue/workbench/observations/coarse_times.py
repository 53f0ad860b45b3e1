"""Gives each row of a reference log its own time if several rows have the same time stamp."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.measurement import Reference

Float = NDArray[np.float64]


def with_spread_times(columns: Reference) -> Reference:
    """Return the columns with a time of its own for each row of a run.

    A logger that writes whole seconds gives the same time to all rows of a second. The true times
    lie between this stamp and the next, so that times in even steps from one stamp to the next are
    wrong by less than the distance of the two stamps.
    """
    if columns.time_s is None:
        return columns
    size = columns.time_s.size
    run = np.zeros(size, dtype=np.int64) if columns.run is None else columns.run
    found = columns.time_s.copy()
    for start, end in run_spans(run):
        found[start:end] = spread(columns.time_s[start:end])
    return replace(columns, time_s=found)


def spread(time_s: Float) -> Float:
    """Return the times of one run, (rows,); rows of one stamp get even steps up to the next stamp.

    The rows of the first stamp count back from the second stamp, and the rows of the last stamp
    count from this stamp. Their step is at most the median step of the rows between, because the
    run may begin and end within a step of the clock. Times that run backwards, are all different or
    are all equal are returned unchanged.
    """
    steps = np.diff(time_s)
    if not np.any(steps == 0.0) or np.any(steps < 0.0) or not np.any(steps > 0.0):
        return time_s
    bounds = np.concatenate([[0], np.flatnonzero(steps > 0.0) + 1, [time_s.size]])
    stamps, counts = time_s[bounds[:-1]], np.diff(bounds)
    way = np.diff(stamps) / counts[:-1]
    inner = way[1:] if way.size > 1 else way
    usual = float(np.median(inner))
    found = time_s.copy()
    for number, (first, last) in enumerate(pairwise(bounds.tolist())):
        place = np.arange(last - first)
        if number == 0:
            own = min(usual, float(way[0]))
            found[first:last] = stamps[1] - own * (last - first - place)
        else:
            own = min(usual, float(way[-1])) if number == way.size else float(way[number])
            found[first:last] = stamps[number] + own * place
    return found
