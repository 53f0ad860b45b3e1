"""Omits the rows of a measurement set that must not be used, and lists them with the reason."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Generic, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.base.units import arcsec_per_count, rad_per_count
from arctrue.measurement import Capture, Reference, Table
from arctrue.workbench.observations.outliers.masked_row import MaskedRow, Reason
from arctrue.workbench.observations.outliers.missing_rows import LEAST_ROWS
from arctrue.workbench.observations.outliers.reference_rows import reference_outliers
from arctrue.workbench.observations.outliers.single_rows import MOST_SHARE, capture_outliers

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Boolean = NDArray[np.bool_]
Channel = TypeVar("Channel", Capture, Reference)


@dataclass(frozen=True)
class UsedRows(Generic[Channel]):
    """The rows of a channel that are used."""

    rows: Channel
    numbers: Integer | None
    """Numbers of these rows in the file (0, 1, …); None if all rows are used."""
    masked: list[MaskedRow]
    outlying_share: float
    """Share of outliers among the checked rows; if it is above MOST_SHARE, no outlier is masked."""


def used_capture_rows(
    capture: Capture, table: Table, separation_rad: float, *, mask_outliers: bool
) -> UsedRows[Capture]:
    """Return the capture without the rows that the set masks and without outliers."""
    kept, masked = _without(capture, "capture", _column_mask(capture), None, "mask")
    if not mask_outliers or table.counts_per_rev is None or kept.run.size == 0:
        return UsedRows(kept, _numbers(capture, masked), masked, 0.0)
    count_arcsec = arcsec_per_count(table.counts_per_rev)
    angle = kept.head1_counts.astype(np.float64) * rad_per_count(table.counts_per_rev)
    revolution = np.floor_divide(kept.head1_counts, table.counts_per_rev)
    revolution = revolution - revolution.min() + kept.run * (np.ptp(revolution) + 1)
    outlying, away = np.zeros(kept.run.size, dtype=bool), np.zeros(kept.run.size)
    places_rad = (separation_rad, *np.radians((table.places_deg or ())[2:]).tolist())
    for counts, place_rad in zip(kept.heads[1:], places_rad, strict=True):
        difference = (counts - kept.head1_counts).astype(np.float64) * count_arcsec
        found, by = capture_outliers(
            difference, angle, revolution, run_spans(kept.run), place_rad, count_arcsec
        )
        away = np.where(found & ~outlying, by, away)
        outlying |= found
    return _with_outliers(capture, kept, "capture", masked, outlying, away)


def used_reference_rows(
    reference: Reference, table: Table, *, mask_outliers: bool
) -> UsedRows[Reference]:
    """Return the reference without the rows that the set masks and without outliers."""
    kept, masked = _without(reference, "reference", _column_mask(reference), None, "mask")
    if not mask_outliers or kept.error_arcsec.size < LEAST_ROWS:
        return UsedRows(kept, _numbers(reference, masked), masked, 0.0)
    counts = table.counts_per_rev
    outlying, away = reference_outliers(kept, None if counts is None else arcsec_per_count(counts))
    return _with_outliers(reference, kept, "reference", masked, outlying, away)


def duplicates(reference: Reference) -> Boolean:
    """Return True for each row that equals an earlier row in every column, also in the time.

    A file that was joined with itself has such rows; two true readings have different times.
    Without times no row is a duplicate, because a coarse display repeats its readings.
    """
    size = reference.error_arcsec.size
    if reference.time_s is None or size == 0:
        return np.zeros(size, dtype=bool)
    columns = [
        reference.target_deg,
        reference.error_arcsec,
        reference.run,
        reference.time_s,
        reference.cycle,
        reference.direction,
        reference.head1_counts,
        reference.temperature_c,
        reference.u_arcsec,
        *reference.conditions.values(),
    ]
    there = np.stack([column for column in columns if column is not None], axis=1)
    first = np.unique(there, axis=0, return_index=True)[1]
    again = np.ones(size, dtype=bool)
    again[first] = False
    return again


def counted_once(used: UsedRows[Reference], again: Boolean) -> UsedRows[Reference]:
    """Return the used rows of a reference with their numbers in the file; list the rows in
    ``again``, which were omitted before, as duplicates."""
    listed = [
        MaskedRow("reference", row + 2, "duplicate") for row in np.flatnonzero(again).tolist()
    ]
    used = _numbered_in_the_file(used, again)
    return replace(used, masked=sorted([*used.masked, *listed], key=_line))


def _numbered_in_the_file(used: UsedRows[Channel], omitted: Boolean) -> UsedRows[Channel]:
    """Return the used rows with their numbers in the file, from which the rows in ``omitted`` were
    omitted before."""
    if not omitted.any():
        return used
    left = np.flatnonzero(~omitted)
    listed = [replace(item, row=int(left[item.row - 2]) + 2) for item in used.masked]
    numbers = left if used.numbers is None else left[used.numbers]
    return replace(used, numbers=numbers, masked=listed)


def without_rows(used: UsedRows[Capture], left_out: Boolean) -> UsedRows[Capture]:
    """Return the used rows of a capture without the rows in ``left_out``, shape (used rows,)."""
    numbers = np.arange(left_out.size) if used.numbers is None else used.numbers
    return replace(used, rows=used.rows.where(~left_out), numbers=numbers[~left_out])


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
    # If so many rows are outliers, they are not single wrong rows: all rows stay, and the check of
    # the data reports the fault.
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
    """Return ``rows`` without the rows where ``out`` is True, and the omitted rows. ``numbers``:
    number of each row in its file, from 0."""
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
