"""Converts the columns of a measurement set to rows with their conditions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.measurement.measurement_set import HEAD_COLUMNS
from arctrue.measurement.wraps import same_turn
from arctrue.workbench.observations.coarse_times import with_spread_times
from arctrue.workbench.observations.head_noise import HeadNoise, head_noise, samples_for_noise
from arctrue.workbench.observations.observations import Observations
from arctrue.workbench.observations.outliers.masked_row import MaskedRow
from arctrue.workbench.observations.part import part_of, part_of_reference
from arctrue.workbench.observations.polygon_faces import faces_of
from arctrue.workbench.observations.reference_angle import reading_and_angle
from arctrue.workbench.observations.reference_speed import reference_speed
from arctrue.workbench.observations.rows import ReferenceRows
from arctrue.workbench.observations.run_speed import run_speeds
from arctrue.workbench.observations.run_turns import rows_of_short_runs
from arctrue.workbench.observations.since_reversal import since_reversal
from arctrue.workbench.observations.stored import RunFacts, StoredCapture, electrical_rad
from arctrue.workbench.observations.thermometer import without_sensor_noise
from arctrue.workbench.observations.true_angle import true_angle
from arctrue.workbench.observations.used_rows import (
    counted_once,
    duplicates,
    used_capture_rows,
    used_reference_rows,
    without_rows,
)
from arctrue.workbench.observations.wrapped_targets import unwrapped

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

MOST_TURNS = 1_000_000
"""Largest number of turns from the index. Farther away, rounding to double precision changes an
angle by about a thousandth of a count (at 2²⁴ counts per turn).
"""
LONGEST_PAUSE_S = 30.0 * 86_400.0
"""Longest pause between the two channels of a set. A longer pause means that their times have
different zeros, for example the start of the file and 1970."""
MOST_COUNTS = 2**62 - 1
"""Largest absolute value of a count at which the difference of two heads fits into 64 bits."""


def observations_of(
    measurement: MeasurementSet,
    reference_temperature_c: float | None = None,
    *,
    mask_outliers: bool = True,
) -> Observations:
    """Make the observations of a measurement set.

    ``reference_temperature_c`` is T₀ of a model that was fitted to another set; without it T₀ is
    the median temperature of the set, or 0 if the set has no temperature. ``mask_outliers``: if
    False, every row is used except the rows that the set masks.

    Raises ValueError for a capture without counts_per_rev or head_separation_deg, with another
    number of heads than the table has angles, or with a count too far from the index. Raises it
    also for a channel whose rows are all masked.
    """
    facts, capture, reference = measurement.table, measurement.capture, measurement.reference
    separation = float(np.radians(facts.head_separation_deg or 0.0))
    masked: list[MaskedRow] = []
    used_capture = used_reference = None
    outlying_share = {}
    left_out: list[str] = []
    says_which_rows = capture is not None and capture.trusted is not None
    if capture is not None:
        _require_a_place_each(facts, capture)
        used = used_capture_rows(capture, facts, separation, mask_outliers=mask_outliers)
        _require_rows("capture", used.rows.run.size, capture.run.size)
        short, left_out = rows_of_short_runs(used.rows, facts.counts_per_rev)
        if short.any():
            used = without_rows(used, short)
        capture, used_capture = _with_quiet_thermometer(used.rows), used.numbers
        masked += used.masked
        outlying_share["capture"] = used.outlying_share
    if reference is not None:
        again = duplicates(reference)
        once = reference.where(~again) if again.any() else reference
        there = used_reference_rows(
            unwrapped(with_spread_times(once)), facts, mask_outliers=mask_outliers
        )
        there = counted_once(there, again)
        _require_rows("reference", there.rows.error_arcsec.size, reference.error_arcsec.size)
        reference, used_reference = there.rows, there.numbers
        masked += there.masked
        outlying_share["reference"] = there.outlying_share
    warmths = [
        channel.temperature_c
        for channel in (capture, reference)
        if channel is not None and channel.temperature_c is not None
    ]
    usual = float(np.median(np.concatenate(warmths))) if warmths else 0.0
    if reference_temperature_c is not None:
        usual = reference_temperature_c
    faces = facts.faces
    if faces is None and reference is not None:
        faces = reference.faces
    start_s, reference_start_s = _session_starts_s(capture, reference)
    stored = (
        None if capture is None else _stored_capture(facts, capture, separation, usual, start_s)
    )
    if stored is not None and reference is not None and reference.time_s is not None:
        stored = replace(stored, reference_in_time=True)
    part, whole = (None, None) if stored is None else part_of(stored)
    compared = compared_whole = None
    if reference is not None:
        compared = _reference_rows(
            facts,
            reference,
            usual,
            faces,
            reference_start_s,
            two_heads=capture is not None,
        )
        compared = replace(
            compared,
            capture_runs=0 if part is None else part.runs,
            heads=2 if part is None else part.heads,
        )
        compared, compared_whole = part_of_reference(compared)
    return Observations(
        title=measurement.title,
        capture=part,
        stored=whole,
        reference=compared,
        stored_reference=compared_whole,
        counts_per_rev=facts.counts_per_rev,
        grating_lines=facts.grating_lines,
        head_separation_rad=separation,
        heads=2 if capture is None else len(capture.heads),
        drive_gear_teeth=facts.drive_gear_teeth,
        disc_diameter_mm=facts.disc_diameter_mm,
        masked=tuple(masked),
        left_out=tuple(left_out),
        may_mask=mask_outliers and not says_which_rows,
        outlying_share=outlying_share,
        used_capture_rows=used_capture,
        capture_sample=None if stored is None else stored.sample,
        used_reference_rows=used_reference,
        index_repeatability_counts=facts.index_repeatability_counts,
        reference_uncertainty_arcsec=(
            None if reference is None else reference.standard_uncertainty_arcsec
        ),
    )


def _with_quiet_thermometer(capture: Capture) -> Capture:
    """Return the capture with the temperature of its rows without the noise of the sensor."""
    if capture.temperature_c is None:
        return capture
    quiet = without_sensor_noise(capture.temperature_c, capture.time_s, capture.run)
    return replace(capture, temperature_c=quiet)


def _session_starts_s(capture: Capture | None, reference: Reference | None) -> tuple[float, float]:
    """Return the first time of both channels, on the clock of the capture and on the clock of the
    reference; 0 without times."""
    own = None if capture is None else capture.time_s
    there = None if reference is None else reference.time_s
    offset_s = 0.0 if reference is None else reference.clock_offset_s or 0.0
    if own is None or there is None:
        starts = [0.0 if one is None else float(one.min()) for one in (own, there)]
        return starts[0], starts[1]
    apart = max(
        float(own.min() - there.max()) - offset_s, float(there.min() - own.max()) + offset_s
    )
    if apart > LONGEST_PAUSE_S:
        return float(own.min()), float(there.min())
    first = min(float(own.min()), float(there.min()) + offset_s)
    return first, first - offset_s


def _require_rows(channel: str, left: int, rows: int) -> None:
    if not left:
        raise ValueError(
            f"the {channel}: all {rows:,} rows are masked; unmask the good rows (column mask, "
            f"mask.csv), or take {channel}.csv and its section out of the set"
        )


def _require_a_place_each(facts: Table, columns: Capture) -> None:
    if facts.counts_per_rev is None or facts.places_deg is None:
        raise ValueError("a capture needs table.counts_per_rev and table.head_separation_deg")
    if len(facts.places_deg) != len(columns.heads):
        raise ValueError(
            f"table.head_places_deg: expected a place for each of the {len(columns.heads)} heads "
            f"of the capture, found {len(facts.places_deg)}"
        )


def _stored_capture(
    facts: Table, columns: Capture, separation: float, usual_c: float, session_start_s: float
) -> StoredCapture:
    assert facts.counts_per_rev is not None
    for name, counts in enumerate(columns.heads, start=1):
        most = min(MOST_TURNS * facts.counts_per_rev, MOST_COUNTS)
        if max(abs(int(counts.min())), abs(int(counts.max()))) > most:
            raise ValueError(
                f"head{name}_counts of the capture are more than {MOST_TURNS:,} turns "
                f"({facts.counts_per_rev} counts per turn) away from the index mark; expected "
                "counts that start at the index"
            )
    columns = _in_one_turn(facts, columns)
    count_rad = 2.0 * np.pi / facts.counts_per_rev
    run, spans = _runs_in_order(columns.run)
    runs = int(run.max(initial=-1)) + 1
    start_s, direction = np.zeros(runs), np.ones(runs)
    revolution = np.empty(run.size, dtype=np.int32)
    next_revolution = 0
    for start, end in spans:
        number = int(run[start])
        counts = columns.head1_counts[start:end]
        start_s[number] = float(columns.time_s[start])
        direction[number] = 1.0 if counts[-1] >= counts[0] else -1.0
        turns = np.abs(counts - counts[0]) // facts.counts_per_rev
        revolution[start:end] = next_revolution + turns
        next_revolution += int(turns.max(initial=0)) + 1
    reading1 = columns.head1_counts.astype(np.float64)
    reading1 *= count_rad
    difference = (columns.head2_counts - columns.head1_counts).astype(np.float64)
    difference *= count_rad
    difference -= separation
    angle = true_angle(reading1, difference, separation)
    stored = StoredCapture(
        table=facts,
        run=run,
        revolution=revolution,
        time_s=columns.time_s,
        temperature_c=columns.temperature_c,
        head1_counts=columns.head1_counts,
        head2_counts=columns.head2_counts,
        angle_rad=angle,
        speed=run_speeds(angle, columns.time_s, spans, count_rad),
        run_facts=RunFacts(start_s, direction),
        set_start_s=float(columns.time_s.min()),
        session_start_s=session_start_s,
        head_separation_rad=separation,
        reference_temperature_c=usual_c,
        u_arcsec=columns.u_arcsec,
        conditions=columns.conditions,
        further_counts=columns.heads[2:],
    )
    if not stored.further_counts:
        return stored
    return _in_channels(replace(stored, head_noise=_noise_of_heads(stored)), spans)


def _noise_of_heads(stored: StoredCapture) -> HeadNoise | None:
    """Return the noise of the heads of a capture with one row per sample; None: equal noise."""
    assert stored.table.counts_per_rev is not None
    kept = samples_for_noise(stored.run)
    head1 = stored.head1_counts[kept]
    counts = [item[kept] for item in (stored.head2_counts, *stored.further_counts)]
    differences = np.stack([item - head1 for item in counts]).astype(np.float64)
    phases = [electrical_rad(item, stored.table) for item in (head1, *counts)]
    there = [item for item in phases if item is not None]
    return head_noise(
        differences * (ARCSEC_PER_TURN / stored.table.counts_per_rev),
        stored.run[kept],
        stored.angle_rad[kept],
        stored.time_s[kept],
        np.stack(there) if there else None,
    )


def _in_one_turn(facts: Table, columns: Capture) -> Capture:
    """Shift the counts of each further head by whole turns, so that they are nearest to those of
    head 1 plus the angle of this head.

    A head that passes its index mark later than head 1 counts from a later turn.
    """
    assert facts.counts_per_rev is not None
    assert facts.places_deg is not None
    shifted: dict[str, Any] = {
        name: same_turn(
            columns.head1_counts, counts, columns.run, facts.counts_per_rev, float(place_deg)
        )
        for name, counts, place_deg in zip(
            HEAD_COLUMNS[1:], columns.heads[1:], facts.places_deg[1:], strict=False
        )
    }
    return replace(columns, **shifted)


def _in_channels(stored: StoredCapture, spans: list[tuple[int, int]]) -> StoredCapture:
    """Return the rows of each run once per channel, one channel after the other.

    A channel is one of the differences of heads that three or more heads provide.
    """
    channels = len(stored.further_counts) + 1
    sample = np.concatenate([np.tile(np.arange(start, end), channels) for start, end in spans])
    channel = np.concatenate([np.repeat(np.arange(channels), end - start) for start, end in spans])
    small = channel.astype(np.int32)
    facts, temperature = stored.run_facts, stored.temperature_c
    return replace(
        stored,
        run=stored.run[sample] * np.int32(channels) + small,
        revolution=stored.revolution[sample] * np.int32(channels) + small,
        time_s=stored.time_s[sample],
        temperature_c=None if temperature is None else temperature[sample],
        angle_rad=stored.angle_rad[sample],
        speed=stored.speed.in_channels(channels, sample),
        run_facts=RunFacts(
            np.repeat(facts.start_s, channels), np.repeat(facts.direction, channels)
        ),
        u_arcsec=None if stored.u_arcsec is None else stored.u_arcsec[sample],
        conditions={name: column[sample] for name, column in stored.conditions.items()},
        sample=sample,
        channel=channel,
    )


def _runs_in_order(names: Integer) -> tuple[NDArray[np.int32], list[tuple[int, int]]]:
    """Number the runs in the order of the file.

    Also return the first row and the row after the last of each stretch of successive rows with one
    run number.
    """
    spans = run_spans(names)
    numbers: dict[int, int] = {}
    run = np.empty(names.size, dtype=np.int32)
    for start, end in spans:
        run[start:end] = numbers.setdefault(int(names[start]), len(numbers))
    return run, spans


def _reference_rows(
    facts: Table,
    columns: Reference,
    usual_c: float,
    faces: int | None,
    session_start_s: float,
    *,
    two_heads: bool,
) -> ReferenceRows:
    target = np.radians(columns.target_deg)
    run = np.zeros(target.size, dtype=np.int64) if columns.run is None else columns.run
    # The phase is calculated from counts alone, because target + error would add the noise of ε to
    # the phase.
    electrical = electrical_rad(columns.head1_counts, facts)
    time = columns.time_s
    reading, angle = reading_and_angle(facts, columns)
    reversals, travel, at_reversal = (
        (None, None, None)
        if columns.direction is None
        else since_reversal(target, columns.direction)
    )
    return ReferenceRows(
        run=run,
        cycle=columns.cycle,
        time_s=time,
        temperature_c=columns.temperature_c,
        direction=None if columns.direction is None else columns.direction.astype(np.float64),
        target_rad=target,
        angle_rad=angle,
        # With two heads, line_rad is the reading, which shows the disc. With one head, the rows
        # cannot show whether a high order is fixed to the disc or to the angle of the table (for
        # example a motor's cogging), so line_rad is the angle.
        line_rad=reading if two_heads else angle,
        face=faces_of(faces, run, columns.target_deg),
        faces=faces,
        electrical1_rad=electrical,
        teeth=facts.drive_gear_teeth,
        speed_rad_s=reference_speed(columns),
        run_start_s=_run_start(run, time),
        set_start_s=0.0 if time is None else float(time.min()),
        session_start_s=session_start_s,
        middle_time_s=0.0
        if time is None or time.size == 0
        else float(0.5 * (time.min() + time.max())),
        reference_temperature_c=usual_c,
        error_arcsec=columns.error_arcsec - float(np.mean(columns.error_arcsec)),
        u_arcsec=columns.u_arcsec,
        reversals=reversals,
        travel_rad=travel,
        at_reversal=at_reversal,
        conditions=columns.conditions,
    )


def _run_start(run: Integer, time_s: Float | None) -> Float | None:
    if time_s is None:
        return None
    _, first, inverse = np.unique(run, return_index=True, return_inverse=True)
    return np.asarray(time_s[first][inverse])
