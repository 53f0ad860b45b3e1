"""Finds a head whose counter starts anew within a turn, or after a number of counts that is not a
whole number of turns.

Such a counter falls by the same number of counts each time. The steps of slips differ in size.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans

Float = NDArray[np.float64]

LEAST_JUMP_TURNS = 1.0 / 64.0
"""Smallest jump that is examined, in turns. This limit is a choice: a counter of fewer counts wraps
more than 64 times a turn, and jumps by lost lines are smaller."""
LEAST_STEPS = 10.0
"""Smallest jump in usual steps from row to row: a missing row of an uneven motion causes smaller
jumps."""
LEAST_WRAPS = 2
"""Smallest number of jumps: a single jump may be a slip."""
ALIKE_STEPS = 3.0
"""Largest difference of the jumps, and largest excess of the range of the counts over the jump, in
usual steps: some rows next to a jump may be missing."""


@dataclass(frozen=True)
class Wraps:
    """Jumps of a counter that starts anew."""

    places: list[tuple[int, int]]
    """Run, and row within the run, of the first row after each jump."""
    moved: float
    """Change of the count at the first jump, from row to row."""
    modulus: float
    """Number of counts after which the counter starts anew."""


def wraps_of(counts: Float, run: NDArray[np.integer], counts_per_rev: float) -> Wraps | None:
    """Return the jumps of a head whose counts, (rows,), start anew; None without such jumps.

    ``run``: number of the run of each row; the rows of a run are neighbours.
    """
    least = LEAST_JUMP_TURNS * counts_per_rev
    places: list[tuple[int, int]] = []
    jumps: list[float] = []
    usual: list[float] = []
    ranges: list[float] = []
    for number, (start, end) in enumerate(run_spans(run)):
        step = np.diff(counts[start:end])
        if step.size == 0:
            continue
        even = float(np.median(step))
        away = step - even
        far = np.flatnonzero(np.abs(away) > max(LEAST_STEPS * abs(even), least))
        # A counter that starts anew jumps against the motion.
        far = far[away[far] * even < 0.0]
        places += [(number, row + 1) for row in far.tolist()]
        jumps += np.abs(away[far]).tolist()
        usual.append(abs(even))
        if far.size:
            # Another run may be shifted by whole turns.
            ranges.append(float(np.ptp(counts[start:end])))
    if len(jumps) < LEAST_WRAPS:
        return None
    modulus, allowed = float(np.median(jumps)), ALIKE_STEPS * max(usual)
    if np.max(np.abs(np.asarray(jumps) - modulus)) > allowed:
        return None
    if max(ranges) > modulus + allowed:
        return None
    number, row = places[0]
    first = run_spans(run)[number][0] + row
    return Wraps(places, float(counts[first] - counts[first - 1]), modulus)
