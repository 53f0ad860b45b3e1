"""The noise of each channel from its own repeats."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]

LARGEST_GAP_STEPS = 8.0
"""Rows further apart than this, in the run's own steps, have a gap between them."""


def capture_noise_arcsec(observations: Observations, residual: Float) -> float:
    """Standard deviation of one row, from turn to turn at the same angle within each run.

    The later revolution is interpolated linearly at the angles of the earlier one, which leaves
    (1 − f)² + f² of its variance. With single turns: from sample to sample.
    """
    rows = observations.capture
    assert rows is not None
    square, freedom = 0.0, 0.0
    for first, last in run_spans(rows.run):
        inside = slice(first, last)
        angle = rows.angle_rad[inside] * (1.0 if rows.direction[first] > 0 else -1.0)
        values = residual[inside]
        ahead = angle + 2.0 * np.pi
        there = np.flatnonzero(ahead <= angle[-1])
        if there.size < 16 or np.any(np.diff(angle) <= 0):
            continue
        place = np.searchsorted(angle, ahead[there], side="right") - 1
        place = np.minimum(place, angle.size - 2)
        # Where the part of a long capture has a gap, no row repeats the earlier one.
        near = angle[place + 1] - angle[place] < LARGEST_GAP_STEPS * np.median(np.diff(angle))
        there, place = there[near], place[near]
        if there.size < 16:
            continue
        fraction = (ahead[there] - angle[place]) / (angle[place + 1] - angle[place])
        later = (1.0 - fraction) * values[place] + fraction * values[place + 1]
        weight = 1.0 + (1.0 - fraction) ** 2 + fraction**2
        difference = later - values[there]
        difference -= difference.mean()
        square += float(np.sum(difference**2 / weight))
        freedom += there.size - 1
    if freedom < 16:
        difference = np.diff(residual)[np.diff(rows.run) == 0]
        return float(np.sqrt(0.5 * np.mean(difference**2))) if difference.size else 0.0
    return float(np.sqrt(square / freedom))


def reference_noise_arcsec(observations: Observations, residual: Float) -> float:
    """Standard deviation of one row, from visit to visit of the same station and direction.

    Successive visits are compared, so that a slow drift counts little.
    """
    rows = observations.reference
    assert rows is not None
    station = np.round(np.mod(rows.target_rad, 2.0 * np.pi) * 1e6).astype(np.int64)
    side = np.zeros_like(station) if rows.direction is None else rows.direction.astype(np.int64)
    _, group = np.unique(np.stack([station, side]), axis=1, return_inverse=True)
    group = np.asarray(group).reshape(-1)
    order = np.argsort(group, kind="stable")
    same = np.diff(group[order]) == 0
    difference = np.diff(residual[order])[same]
    if difference.size < 4:
        neighbours = np.diff(residual)
        return float(np.sqrt(0.5 * np.mean(neighbours**2))) if neighbours.size else 0.0
    return float(np.sqrt(0.5 * np.mean(difference**2)))
