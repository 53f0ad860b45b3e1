"""Handles rows whose time steps back: either a new run begins there, or the rows are out of order
and are sorted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.choices import Ambiguous, Choices
from arctrue.importing.file_rows import FileRows

Float = NDArray[np.float64]

ORDERS = ("sort", "runs")
ANEW_SHARE = 0.05
"""The pieces between steps back in time are runs if the range of their first times is at most this
share of the whole time span, and if they have LEAST_ROWS_A_RUN rows or more on average."""
LEAST_ROWS_A_RUN = 8
SHORTER = 0.75
"""Largest ratio of the travel after sorting to the travel before sorting for which the rows are
sorted without a question."""


def in_order(rows: FileRows, said: str, choices: Choices) -> FileRows:
    """Return the rows unchanged, or sorted by time within each run of the file.

    ``said`` is the user's statement: ``sort``, ``runs`` (each step back begins a run), or "".
    Without a statement, the rows remain unchanged if the pieces between steps back are long and all
    begin near the same time. Otherwise, they are sorted if sorting makes the travel of the table
    much shorter. In all other cases the user is asked. Raises AmbiguousError if nobody answers.
    """
    time_s = rows.time_s
    if time_s is None or time_s.size < 2:
        return rows
    run = rows.whole.get("run", np.zeros(time_s.size, dtype=np.int64))
    back = np.flatnonzero((np.diff(time_s) < 0.0) & (np.diff(run) == 0)) + 1
    if back.size == 0:
        return rows
    _, first, number = np.unique(run, return_index=True, return_inverse=True)
    order = np.lexsort((time_s, first[number]))
    if not said and not _begins_anew(time_s, back):
        if _is_safe(rows, order):
            said = "sort"
        else:
            said = choices.ask(
                Ambiguous(
                    "--order",
                    f"{rows.name}: time steps back {back.size} times, first at row "
                    f"{rows.line(int(back[0]))}, from {time_s[back[0] - 1]:g} to "
                    f"{time_s[back[0]]:g} s. Sort the rows by time, or begin a new run "
                    "at each of these rows?",
                    ORDERS,
                )
            )
    if said != "sort":
        return rows
    choices.note(
        f"{rows.name}: time steps back {back.size} times, first at row "
        f"{rows.line(int(back[0]))}; the rows are sorted by time"
    )
    return rows.taken(order)


def _begins_anew(time_s: Float, back: NDArray[np.int64]) -> bool:
    """Tell whether the pieces between steps back are long enough for runs and begin together."""
    starts = time_s[np.concatenate(([0], back))]
    long = time_s.size >= LEAST_ROWS_A_RUN * starts.size
    return bool(long and float(np.ptp(starts)) <= ANEW_SHARE * float(np.ptp(time_s)))


def _is_safe(rows: FileRows, order: NDArray[np.int64]) -> bool:
    """Tell whether all times differ (needed only without a column of runs) and sorting makes the
    travel much shorter.

    Only steps that sorting changes are compared, because a few misplaced rows hardly change the
    travel of all rows.
    """
    assert rows.time_s is not None
    time_s = rows.time_s[order]
    if "run" not in rows.whole and (np.diff(time_s) <= 0.0).any():
        return False
    angle = next((rows.angles[name] for name in ("target", "head1") if name in rows.angles), None)
    if angle is None:
        return False
    # Exclude the steps that sorting does not change.
    same = np.flatnonzero(np.diff(order) == 1)
    before, after = _steps(angle), _steps(angle[order])
    changed_before = np.ones(before.size, dtype=bool)
    changed_before[order[same]] = False
    changed_after = np.ones(after.size, dtype=bool)
    changed_after[same] = False
    own_way = float(before[changed_before].sum())
    return float(after[changed_after].sum()) < SHORTER * own_way


def _steps(angle: Float) -> Float:
    step = np.diff(angle)
    return np.asarray(np.abs(step - np.round(step)))
