"""Finds runs in which two heads count in opposite directions, for example because A and B of one
head are exchanged.

The readings of two heads of one disc differ by an angle and by errors of arcseconds, so the travel
of one head follows the travel of the other with the slope 1. If one head counts backwards, the
slope is −1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans

Float = NDArray[np.float64]

LEAST_TRAVEL_TURNS = 1.0 / 360.0
"""Smallest travel of a run that is examined: 1°. This limit is a choice: the vibration of an axis,
which opposite heads see with opposite signs, is far smaller."""
SLOPE_TOLERANCE = 0.1
"""Largest deviation of the slope from −1: errors of the disc change the slope by about 10⁻³, and a
stretch in which a head stands still by its share of the run."""


def opposite_runs(
    first: NDArray[Any], other: NDArray[Any], run: NDArray[np.integer], counts_per_rev: float
) -> list[int]:
    """Return the runs, numbered from 0, in which two heads count in opposite directions.

    ``first``, ``other``: counts of the heads, (rows,); the rows of a run are neighbours. A
    counter may start anew after whole turns.
    """
    return [
        number
        for number, (start, end) in enumerate(run_spans(run))
        if _is_opposite(
            _travel(first[start:end], counts_per_rev), _travel(other[start:end], counts_per_rev)
        )
    ]


def said_of(head: int, opposite: list[int], runs: int) -> str:
    """Return the sentence about heads 1 and ``head``, which count in opposite directions in the
    runs ``opposite`` of ``runs``."""
    numbers = ", ".join(map(str, opposite))
    where = f"run{'s' if len(opposite) > 1 else ''} {numbers}"
    if len(opposite) == runs:
        where = "every run"
    return (
        f"heads 1 and {head} count in opposite directions in {where}; are A and B of head {head} "
        "(or of head 1) swapped?"
    )


def _travel(counts: NDArray[Any], counts_per_rev: float) -> Float:
    """Return the travel of a head from row to row, in turns, minus its mean."""
    step = np.diff(counts) / counts_per_rev
    travel = np.cumsum(step - np.round(step))
    return np.asarray(travel - travel.mean()) if travel.size else travel


def _is_opposite(first: Float, other: Float) -> bool:
    if first.size < 2 or np.ptp(first) < LEAST_TRAVEL_TURNS:
        return False
    slope = float(first @ other) / float(first @ first)
    return abs(slope + 1.0) < SLOPE_TOLERANCE
