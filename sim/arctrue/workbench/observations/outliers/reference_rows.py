"""Finds outliers in a reference run: neighbouring rows show them in passes with closely spaced
rows, repeated visits show them at stations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import Reference
from arctrue.workbench.observations.display_step import display_step
from arctrue.workbench.observations.outliers.far_rows import (
    NORMAL_MAD,
    SIDE_ROWS,
    far_from_neighbours,
    far_threshold,
    lonely,
)
from arctrue.workbench.observations.outliers.missing_rows import (
    LEAST_ROWS,
    pieces_between_gaps,
    without_wave,
)
from arctrue.workbench.observations.outliers.seen_again import repeats
from arctrue.workbench.observations.outliers.single_rows import (
    LEAST_VISITS,
    at_a_step,
    station_outliers,
)
from arctrue.workbench.observations.reading_step import reading_step
from arctrue.workbench.observations.reference_speed import continued, passes_of

Float = NDArray[np.float64]
Boolean = NDArray[np.bool_]

DENSE_STEP_DEG = 1.0
"""Largest median step of a pass whose rows are predicted by their neighbours; rows farther apart
need repeated visits."""
SAME_STATION_DEG = 1e-6
"""Grid to which angles are rounded to find equal stations: 0.004″, the rounding of a file."""


def reference_outliers(rows: Reference, count_arcsec: float | None = None) -> tuple[Boolean, Float]:
    """Return True for outliers, and each row's distance from its neighbours or repeats; (rows,).

    The distances are in arcseconds. ``count_arcsec``: size of a count; None if the set does not
    state it. Readings in whole counts, or in whole steps of any other size, cannot show a scatter
    of less than half a step: a station may have noise although it gives the same count every time.
    """
    # Rounding alone has the standard deviation step/√12, even if all rounded readings are equal.
    rounding = display_step(rows.error_arcsec) / float(np.sqrt(12.0))
    least = max(rows.standard_uncertainty_arcsec or 0.0, rounding)
    if rows.head1_counts is not None and count_arcsec is not None:
        least = max(least, NORMAL_MAD * 0.5 * count_arcsec)
    step_arcsec = reading_step(rows.target_deg, rows.error_arcsec, count_arcsec)
    least = max(least, NORMAL_MAD * 0.5 * step_arcsec)
    passes = passes_of(rows)
    number = np.zeros(rows.error_arcsec.size, dtype=np.int64)
    sense = np.ones(rows.error_arcsec.size, dtype=np.int64)
    gone_deg = continued(rows.target_deg)
    for label, part in enumerate(passes):
        number[part] = label
        sense[part] = 1 if gone_deg[part][-1] >= gone_deg[part][0] else -1
    station = np.round(np.mod(rows.target_deg, 360.0) / SAME_STATION_DEG).astype(np.int64)
    _, place = np.unique(station, return_inverse=True)
    found, away = station_outliers(rows.error_arcsec, place, number, sense, least)
    visited = np.bincount(place)[place]
    scatter = np.ones(away.size)
    dense = np.zeros(away.size, dtype=bool)
    flat = rows.error_arcsec.copy()
    for part in passes:
        step = np.abs(np.diff(gone_deg[part]))
        near = step.size >= LEAST_ROWS and float(np.median(step)) <= DENSE_STEP_DEG
        if near and float(np.median(visited[part])) < LEAST_VISITS:
            pieces = pieces_between_gaps(gone_deg[part])
            flat[part] = without_wave(rows.error_arcsec[part], np.radians(gone_deg[part]))
            away[part], scatter[part] = far_from_neighbours(flat[part], least, pieces=pieces)
            if np.median(scatter[part]) > 0.0:
                threshold = far_threshold(away.size, away[part].size - 2 * SIDE_ROWS)
                found[part] = lonely(away[part], scatter[part], threshold)
                dense[part] = True
    candidates = np.flatnonzero(found & dense)
    turn = np.floor(rows.target_deg / 360.0).astype(np.int64)
    revolution = number * (int(np.ptp(turn)) + 1) + turn - int(turn.min(initial=0))
    real = repeats(candidates, away, scatter, np.radians(rows.target_deg), revolution)
    real |= at_a_step(candidates, flat, away, number)
    found[candidates[real]] = False
    return found, away
