"""Computes the turns of the runs of a capture, and finds the runs that are left out because they
have less than one turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.measurement import Capture

Float = NDArray[np.float64]
Boolean = NDArray[np.bool_]

WHOLE_TURN_TOLERANCE = 0.02
"""A run is expected to have a whole number of turns if its number of turns is nearer than this to a
whole number."""
LEAST_GAP_STEPS = 3.0
"""A step that is longer than this number of usual steps means missing rows, not a change of
speed."""
MOST_FOR_MEDIANS = 100_000
"""The median of a longer capture is calculated from evenly spread rows; their number is at least
this value and less than twice this value."""


@dataclass(frozen=True)
class RunEnds:
    """Turns of each run; (runs,)."""

    turns: Float
    short: Boolean
    """True for a run of less than one turn."""
    ends_in_gap: Boolean
    """True if the part that the last turn lacks is not longer than the longest gap of the
    record."""

    @property
    def too_short(self) -> Boolean:
        """True for a run of less than one turn that no gap explains."""
        return self.short & ~self.ends_in_gap


def run_ends(angle_turns: Float, spans: list[tuple[int, int]]) -> RunEnds:
    """Return the turns of each run; ``angle_turns``: angle of each row, in turns."""
    turns = np.array([_turns(angle_turns[start:end]) for start, end in spans])
    # A record that lacks rows inside its runs may lack rows at their ends as well.
    dropped = max(_longest_gap(angle_turns[start:end]) for start, end in spans)
    short = turns < 1.0 - WHOLE_TURN_TOLERANCE
    return RunEnds(turns, short, np.ceil(turns) - turns <= dropped)


def rows_of_short_runs(capture: Capture, counts_per_rev: int | None) -> tuple[Boolean, list[str]]:
    """Return True for each row of a run of less than one turn, and a sentence on these runs.

    These runs are left out if the other runs have most of the rows. A run in which the table stands
    still is kept, because it is a fault of the data.
    """
    none = np.zeros(capture.run.size, dtype=bool)
    spans = run_spans(capture.run)
    if counts_per_rev is None or len(spans) < 2:
        return none, []
    ends = run_ends(capture.head1_counts / counts_per_rev, spans)
    out = none.copy()
    said = []
    for (start, end), turns, short in zip(spans, ends.turns, ends.too_short, strict=True):
        if short and turns > WHOLE_TURN_TOLERANCE:
            out[start:end] = True
            said.append(f"run {int(capture.run[start])} has {turns:.3f} of a turn")
    if not said or 2 * int(out.sum()) > out.size:
        return none, []
    return out, [
        f"the capture: {'; '.join(said)}, and a whole turn is needed: the diagnosis leaves "
        f"{'this run' if len(said) == 1 else 'these runs'} out and numbers the other runs from 0"
    ]


def _turns(angle_turns: Float) -> float:
    """Return the number of turns of a run, including the step that would follow its last row."""
    size = angle_turns.size
    return abs(float(angle_turns[-1] - angle_turns[0])) * size / max(size - 1, 1)


def _longest_gap(angle_turns: Float) -> float:
    """Return the longest gap between the rows of a run, in turns; 0 where no rows are missing."""
    step = np.abs(np.diff(angle_turns))
    if step.size == 0:
        return 0.0
    longest = float(step.max())
    usual = float(np.median(step[:: max(step.size // MOST_FOR_MEDIANS, 1)]))
    return longest if longest > LEAST_GAP_STEPS * usual else 0.0
