"""Faults of the data themselves, looked for before any effect is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.observations import CaptureRows, Observations
from arctrue.observations.stored import StoredCapture

STEP_TOLERANCE = 0.1
"""A step is plausible within 10 % of its run's median."""
WHOLE_TURN_TOLERANCE = 0.02
"""A run whose turns are nearer than this to a whole number was meant to be whole turns."""


def data_faults(observations: Observations) -> list[str]:
    """What is wrong with the rows, in words: file, run, row, expected, found."""
    # Of a long capture all rows, not only the part that the statistics work on.
    rows = observations.capture if observations.stored is None else observations.stored
    if rows is None:
        return []
    found: list[str] = []
    spans = _run_spans(rows.run)
    for run, (start, end) in enumerate(spans):
        found += _step_faults(rows, run, start, end, observations)
    found += _cut_runs(rows, spans)
    return found


def _run_spans(run: NDArray[np.int64] | NDArray[np.int32]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(run)) + 1
    bounds = [0, *edges.tolist(), run.size]
    return list(pairwise(bounds))


def _step_faults(
    rows: CaptureRows | StoredCapture, run: int, start: int, end: int, observations: Observations
) -> list[str]:
    if end - start < 3:
        return [f"capture, run {run}: only {end - start} samples"]
    # The angle is that of head 1; a slip of one head alone is an effect, not a fault of the data.
    step = np.diff(rows.angle_rad[start:end])
    if isinstance(rows, StoredCapture):
        difference = rows.difference_rad(slice(start, end))
    else:
        difference = rows.difference_arcsec[start:end] * (np.pi / 648_000.0)
    other = step + np.diff(difference)
    typical = float(np.median(step))
    if typical == 0.0:
        return [f"capture, run {run}: the table stands still"]
    lost = (np.abs(step / typical - 1.0) > STEP_TOLERANCE) & (
        np.abs(other / typical - 1.0) > STEP_TOLERANCE
    )
    found = []
    if lost.any():
        first = int(np.flatnonzero(lost)[0])
        counts = observations.counts_per_rev or 1
        in_counts = counts / (2.0 * np.pi)
        found.append(
            f"capture, run {run}, sample {first + 1} of the run (row {start + first + 1} of the "
            f"data): both heads move by {step[first] * in_counts:.0f} counts, expected about "
            f"{typical * in_counts:.0f} (within 10 %); {int(lost.sum())} such steps in this run"
        )
    return found


def _cut_runs(rows: CaptureRows | StoredCapture, spans: list[tuple[int, int]]) -> list[str]:
    turns = np.array(
        [
            abs(rows.angle_rad[end - 1] - rows.angle_rad[start])
            / (2.0 * np.pi)
            * (end - start)
            / max(end - start - 1, 1)
            for start, end in spans
        ]
    )
    found = [
        f"capture, run {run}: {value:.3f} of a turn, a whole turn is needed"
        for run, value in enumerate(turns)
        if value < 1.0 - WHOLE_TURN_TOLERANCE
    ]
    away = np.abs(turns - np.round(turns))
    whole = away < WHOLE_TURN_TOLERANCE
    if turns.size > 2 and whole.sum() >= turns.size - 1 and not whole.all():
        run = int(np.flatnonzero(~whole)[0])
        if turns[run] >= 1.0 - WHOLE_TURN_TOLERANCE:
            found.append(
                f"capture, run {run}: cut after {turns[run]:.3f} turns; the other runs are whole "
                "turns"
            )
    return found
