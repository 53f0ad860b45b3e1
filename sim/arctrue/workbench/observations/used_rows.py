"""Leaves out the rows of a measurement set that must not be used, and tells which and why."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.base.units import arcsec_per_count, rad_per_count
from arctrue.measurement import Capture, Reference, Table
from arctrue.workbench.observations.outliers import (
    LEAST_ROWS,
    LEAST_VISITS,
    MOST_SHARE,
    SIDE_ROWS,
    MaskedRow,
    Reason,
    capture_outliers,
    far_from_neighbours,
    far_threshold,
    lonely,
    pieces_between_gaps,
    repeats,
    station_outliers,
    without_wave,
)
from arctrue.workbench.observations.reference_speed import passes_of

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Boolean = NDArray[np.bool_]
Channel = TypeVar("Channel", Capture, Reference)

DENSE_STEP_DEG = 1.0
"""Rows of a pass as near as this show what lies between them; far ones need repeated visits."""
SAME_STATION_DEG = 1e-6
LEAST_AGAIN = 2.0
"""Times that a rounded value comes again: a file of fewer digits than its noise has more."""
SAME_VALUE = 1e-12
"""Of the largest value: below it two values of a file are one but for their last bit."""
WHOLE_STEPS = 0.01
"""Of a step: what decimals of the file leave of a whole number of steps."""


@dataclass(frozen=True)
class UsedRows(Generic[Channel]):
    """The rows of a channel that are used."""

    rows: Channel
    numbers: Integer | None
    """Their places in the file (0, 1, …); None: all rows are used."""
    masked: list[MaskedRow]
    outlying_share: float
    """Of the rows looked at. If it is above MOST_SHARE no outlier is masked."""


def used_capture_rows(
    capture: Capture, table: Table, separation_rad: float, *, mask_outliers: bool
) -> UsedRows[Capture]:
    """The capture without the rows that the set masks and without outliers."""
    kept, masked = _without(capture, "capture", _column_mask(capture), None, "mask")
    if not mask_outliers or table.counts_per_rev is None or kept.run.size == 0:
        return UsedRows(kept, _numbers(capture, masked), masked, 0.0)
    count_arcsec = arcsec_per_count(table.counts_per_rev)
    difference = (kept.head2_counts - kept.head1_counts).astype(np.float64) * count_arcsec
    angle = kept.head1_counts.astype(np.float64) * rad_per_count(table.counts_per_rev)
    revolution = np.floor_divide(kept.head1_counts, table.counts_per_rev)
    revolution = revolution - revolution.min() + kept.run * (np.ptp(revolution) + 1)
    outlying, away = capture_outliers(
        difference, angle, revolution, run_spans(kept.run), separation_rad, count_arcsec
    )
    return _with_outliers(capture, kept, "capture", masked, outlying, away)


def used_reference_rows(reference: Reference, *, mask_outliers: bool) -> UsedRows[Reference]:
    """The reference without the rows that the set masks and without outliers."""
    kept, masked = _without(reference, "reference", _column_mask(reference), None, "mask")
    if not mask_outliers or kept.error_arcsec.size < LEAST_ROWS:
        return UsedRows(kept, _numbers(reference, masked), masked, 0.0)
    outlying, away = _reference_outliers(kept)
    return _with_outliers(reference, kept, "reference", masked, outlying, away)


def display_step(values: Float) -> float:
    """Step in which an instrument shows its values, 0 where they are not rounded; (rows,) → step.

    The smallest difference of two values, where every difference is a whole number of it and a
    value comes again LEAST_AGAIN times in the mean: values of 64 bits come again only if rounded.
    """
    different = np.unique(values)
    if different.size < 2 or values.size < LEAST_AGAIN * different.size:
        return 0.0
    steps = np.diff(different)
    step = float(steps[steps > SAME_VALUE * float(np.abs(values).max())].min(initial=np.inf))
    if not np.isfinite(step):
        return 0.0
    whole = steps / step
    return step if bool(np.all(np.abs(whole - np.round(whole)) < WHOLE_STEPS)) else 0.0


def _reference_outliers(rows: Reference) -> tuple[Boolean, Float]:
    # Rounding alone scatters by its step over √12, and readings that it makes alike tell no less.
    rounding = display_step(rows.error_arcsec) / float(np.sqrt(12.0))
    least = max(rows.standard_uncertainty_arcsec or 0.0, rounding)
    passes = passes_of(rows)
    number = np.zeros(rows.error_arcsec.size, dtype=np.int64)
    sense = np.ones(rows.error_arcsec.size, dtype=np.int64)
    for label, part in enumerate(passes):
        number[part] = label
        sense[part] = 1 if rows.target_deg[part][-1] >= rows.target_deg[part][0] else -1
    station = np.round(np.mod(rows.target_deg, 360.0) / SAME_STATION_DEG).astype(np.int64)
    _, place = np.unique(station, return_inverse=True)
    found, away = station_outliers(rows.error_arcsec, place, number, sense, least)
    visited = np.bincount(place)[place]
    scatter = np.ones(away.size)
    dense = np.zeros(away.size, dtype=bool)
    for part in passes:
        step = np.abs(np.diff(rows.target_deg[part]))
        near = step.size >= LEAST_ROWS and float(np.median(step)) <= DENSE_STEP_DEG
        if near and float(np.median(visited[part])) < LEAST_VISITS:
            pieces = pieces_between_gaps(rows.target_deg[part])
            flat = without_wave(rows.error_arcsec[part], np.radians(rows.target_deg[part]))
            away[part], scatter[part] = far_from_neighbours(flat, least, pieces=pieces)
            if np.median(scatter[part]) > 0.0:
                threshold = far_threshold(away.size, away[part].size - 2 * SIDE_ROWS)
                found[part] = lonely(away[part], scatter[part], threshold)
                dense[part] = True
    candidates = np.flatnonzero(found & dense)
    turn = np.floor(rows.target_deg / 360.0).astype(np.int64)
    revolution = number * (int(np.ptp(turn)) + 1) + turn - int(turn.min(initial=0))
    real = repeats(candidates, away, scatter, np.radians(rows.target_deg), revolution)
    found[candidates[real]] = False
    return found, away


def _column_mask(rows: Capture | Reference) -> Boolean:
    size = rows.time_s.size if isinstance(rows, Capture) else rows.error_arcsec.size
    return np.zeros(size, dtype=bool) if rows.mask is None else rows.mask


def _with_outliers(
    whole: Channel,
    kept: Channel,
    channel: Literal["capture", "reference"],
    masked: list[MaskedRow],
    outlying: Boolean,
    away: Float,
) -> UsedRows[Channel]:
    if kept.trusted is not None:
        outlying = outlying & ~kept.trusted
    # So many are no single rows: all stay, and the check of the data says that it is faulty.
    share = float(outlying.mean())
    if share > MOST_SHARE:
        return UsedRows(kept, _numbers(whole, masked), masked, share)
    numbers = _numbers(whole, masked)
    left: tuple[Channel, list[MaskedRow]] = _without(
        kept, channel, outlying, numbers, "outlier", away
    )
    everything = sorted([*masked, *left[1]], key=_line)
    return UsedRows(left[0], _numbers(whole, everything), everything, share)


def _line(row: MaskedRow) -> int:
    return row.row


def _numbers(whole: Capture | Reference, masked: list[MaskedRow]) -> Integer | None:
    if not masked:
        return None
    left = np.ones(_column_mask(whole).size, dtype=bool)
    left[[item.row - 2 for item in masked]] = False
    return np.flatnonzero(left)


def _without(
    rows: Channel,
    channel: Literal["capture", "reference"],
    out: Boolean,
    numbers: Integer | None,
    reason: Reason,
    away: Float | None = None,
) -> tuple[Channel, list[MaskedRow]]:
    """``rows`` less those where ``out`` is True; ``numbers``: the place of each row in its file."""
    if not out.any():
        return rows, []
    places = np.flatnonzero(out)
    masked = [
        MaskedRow(
            channel,
            int(place if numbers is None else numbers[place]) + 2,
            reason,
            None if away is None else float(away[place]),
        )
        for place in places.tolist()
    ]
    return rows.where(~out), masked
