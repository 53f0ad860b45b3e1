"""Finds faults of the data, before the search for effects.

A deviation that stays (a slip, a settling), recurs at the same angle (a scratch) or continues
everywhere (a vibration) is a real deviation of the table. A deviation of one row or a few rows,
after which the record continues as before, is a fault of the recording.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from arctrue.base.percent import percent
from arctrue.base.runs import run_spans
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.calibration.opposite_heads import opposite_runs, said_of
from arctrue.workbench.diagnose.scaled_passes import scaled_passes
from arctrue.workbench.diagnose.scaled_reference import scaled_reference
from arctrue.workbench.diagnose.wrapped_counter import wraps_of
from arctrue.workbench.observations import CaptureRows, Observations
from arctrue.workbench.observations.file_lines import file_line
from arctrue.workbench.observations.outliers.excursions import excursions, step_scatter
from arctrue.workbench.observations.outliers.single_rows import MOST_SHARE
from arctrue.workbench.observations.reference_columns import (
    direction_faults,
    frozen_rows,
    saturated_rows,
)
from arctrue.workbench.observations.run_turns import (
    MOST_FOR_MEDIANS,
    WHOLE_TURN_TOLERANCE,
    RunEnds,
    run_ends,
)
from arctrue.workbench.observations.stored import StoredCapture

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
Boolean = NDArray[np.bool_]

STEP_TOLERANCE = 0.1
"""Largest relative deviation of a plausible step from the steps around it. A step is the change of
the angle from one row to the next."""
LOST_SIGMA = 8.0
"""Smallest deviation of an implausible step, in standard deviations of the noise of a step. If the
rows are closely spaced, with steps of only a few counts, this limit exceeds STEP_TOLERANCE times
the step.
"""
MOST_SLIPS = 8
"""Largest number of slips of a head in a run; with more slips, the head itself counts as faulty."""
LEAST_MOVE_COUNTS = 4.0
"""A head that keeps its count is frozen only if the usual step of the other head is at least this
large. Normal noise of one count cancels a step of four counts in one row of 4,000."""
TEMPERATURES_C = (-60.0, 200.0)
"""Lowest and highest plausible temperature. These limits are a choice: no table is in a colder or
warmer place, and a broken sensor reads a limit of its range."""
TEMPERATURE_JUMP_K = 3.0
"""Smallest spike that is a fault: no table's temperature changes by this much and back within three
rows."""
SEPARATION_DEG = 0.5
"""Smallest error of the stated head separation that is a fault: half a millimetre at the disc. A
smaller error of the mounting is an effect."""
AROUND_ROWS = 31
"""Number of rows from which the usual step is calculated: the speed may change slowly, but not from
row to row."""


def data_faults(observations: Observations) -> list[str]:
    """Describe the faults of the rows, each with its channel and, if they apply, run, row, expected
    value and found value."""
    found: list[str] = []
    # All rows of a long capture are examined, not only the rows that the statistics use.
    for rows in observations.pairs():
        wrapped = _wrapped_counters(rows, observations)
        found += wrapped
        if wrapped:
            # The jumps of the counter falsify the angle between the heads and the steps.
            continue
        opposite = _opposite_heads(rows, observations)
        found += opposite
        if opposite:
            # R₂ − R₁ is then no angle between the heads.
            continue
        found += _separation_fault(rows)
        spans = run_spans(rows.run)
        for run, (start, end) in enumerate(spans):
            found += _step_faults(rows, run, start, end, observations)
        if rows.head == 2:
            found += _temperature_faults(
                "capture", rows.temperature_c, observations.used_capture_rows
            )
    # A fault of head 1 or of the time stamps is found again in the difference to every other head.
    found = list(dict.fromkeys(found))
    stations = observations.every_reference_row
    limits: list[str] = []
    if stations is not None:
        found += _temperature_faults(
            "reference", stations.temperature_c, observations.used_reference_rows
        )
        found += direction_faults(stations, observations.used_reference_rows)
        # Readings at a limit are equal rows as well, and their scatter of 0 makes other rows
        # outliers.
        limits = saturated_rows(stations, observations.used_reference_rows)
        found += limits or frozen_rows(stations, observations.used_reference_rows)
        found += scaled_passes(observations) or scaled_reference(observations)
    found += [
        f"{channel}: {percent(share)} of the rows are outliers, each far from the rows around it; "
        f"at most {percent(MOST_SHARE)} are left out as single wrong rows"
        for channel, share in observations.outlying_share.items()
        if share > MOST_SHARE and not (limits and channel == "reference")
    ]
    return found


def _separation_fault(rows: CaptureRows | StoredCapture) -> list[str]:
    """Describe the fault if the angle of a head differs from its stated angle by more than mounting
    allows."""
    thin = slice(None, None, max(rows.run.size // MOST_FOR_MEDIANS, 1))
    if isinstance(rows, StoredCapture):
        difference = rows.difference_rad(thin)
    else:
        difference = rows.difference_arcsec[thin] * RAD_PER_ARCSEC
    away_deg = float(np.degrees(np.median(difference)))
    nominal_deg = float(np.degrees(rows.head_separation_rad))
    if abs(away_deg) < SEPARATION_DEG:
        return []
    return [
        f"capture: head {rows.head} reads {nominal_deg + away_deg:.3f}° ahead of head 1, expected "
        f"{nominal_deg:g}° within {SEPARATION_DEG:g}°; check "
        f"{'head_separation_deg' if rows.head == 2 else 'head_places_deg'} and "
        "counts_per_rev, which column is which head, and that both count from the index mark"
    ]


def _wrapped_counters(rows: CaptureRows | StoredCapture, observations: Observations) -> list[str]:
    """Describe each head of a pair whose counter starts anew within the capture."""
    spans, found = run_spans(rows.run), []
    in_counts = (observations.counts_per_rev or 1) / (2.0 * np.pi)
    reading, other = _readings(rows, slice(None), in_counts)
    for head, counts in ((1, reading), (rows.head, other)):
        wraps = wraps_of(counts, rows.run, float(observations.counts_per_rev or 1))
        if wraps is None:
            continue
        run, row = wraps.places[0]
        found.append(
            f"capture, run {run}, {_place(row, spans[run][0], observations)}: head {head} moves by "
            f"{wraps.moved:+,.0f} counts, as in {len(wraps.places)} rows of the capture: its "
            f"counter starts anew about every {wraps.modulus:,.0f} counts; expected counts that "
            "continue from row to row, or start anew at counts_per_rev"
        )
    return found


def _opposite_heads(rows: CaptureRows | StoredCapture, observations: Observations) -> list[str]:
    """Describe the fault if the heads of a pair count in opposite directions."""
    counts_per_rev = float(observations.counts_per_rev or 1)
    reading, other = _readings(rows, slice(None), counts_per_rev / (2.0 * np.pi))
    opposite = opposite_runs(reading, other, rows.run, counts_per_rev)
    if not opposite:
        return []
    return [f"capture: {said_of(rows.head, opposite, len(run_spans(rows.run)))}"]


def _readings(
    rows: CaptureRows | StoredCapture, part: slice, in_counts: float
) -> tuple[Float, Float]:
    """Return the counts of head 1 and of the other head, the latter minus its nominal angle."""
    if isinstance(rows, StoredCapture):
        first = rows.head1_counts[part].astype(np.float64)
        return first, first + rows.difference_rad(part) * in_counts
    first = rows.line1_rad[part] * in_counts
    return first, first + rows.difference_arcsec[part] * (RAD_PER_ARCSEC * in_counts)


def _step_faults(
    rows: CaptureRows | StoredCapture, run: int, start: int, end: int, observations: Observations
) -> list[str]:
    if end - start < 3:
        return [f"capture, run {run}: only {end - start} samples"]
    # The readings are examined, not the true angle: a fault of a head falsifies the error of the
    # disc with which the true angle of every row is calculated.
    in_counts = (observations.counts_per_rev or 1) / (2.0 * np.pi)
    if isinstance(rows, StoredCapture):
        reading = rows.head1_counts[start:end] / in_counts
        difference = rows.difference_rad(slice(start, end))
    else:
        reading = rows.line1_rad[start:end]
        difference = rows.difference_arcsec[start:end] * RAD_PER_ARCSEC
    step = np.diff(reading)
    other = step + np.diff(difference)
    if reading[-1] == reading[0]:
        return [f"capture, run {run}: the table stands still"]
    if rows.time_s[end - 1] <= rows.time_s[start]:
        return [
            f"capture, run {run}: time_s stays at {rows.time_s[start]:g} s from the first row of "
            "the run to the last; expected the time of every sample"
        ]
    passed = np.diff(rows.time_s[start:end])
    found: list[str] = []
    for head, own, moving in ((1, step, other), (rows.head, other, step)):
        found += [
            f"capture, run {run}, {_place(first, start, observations)}, and the {length} rows "
            f"after it: head {head} keeps one count while another head moves; mask these rows "
            "(mask.csv)"
            for first, length in _frozen(own * in_counts, moving * in_counts)
        ]
    if found:
        # The steps around a frozen head have no usual size.
        return found
    wrong = [_implausible(step, passed), _implausible(other, passed)]
    lost = wrong[0] & wrong[1]
    if not (wrong[0].any() or wrong[1].any()):
        return found
    expected = _expected_step(step, passed)
    if lost.any():
        first = int(np.flatnonzero(lost)[0])
        found.append(
            f"capture, run {run}, {_place(first + 1, start, observations)}: "
            f"{'both heads' if observations.heads == 2 else f'heads 1 and {rows.head}'} move by "
            f"{step[first] * in_counts:.0f} counts, expected about "
            f"{expected[first] * in_counts:.0f} (within 10 %) from the rows around it and the time "
            f"stamps; {int(lost.sum())} such steps in this run"
        )
    # A step that stays is an effect, because a head may slip once. A head with more than MOST_SLIPS
    # such steps is faulty.
    for head, bad in zip((1, rows.head), wrong, strict=True):
        alone = np.flatnonzero(bad & ~lost)
        if alone.size > MOST_SLIPS:
            moved = (step if head == 1 else other)[alone[0]]
            found.append(
                f"capture, run {run}, {_place(int(alone[0]) + 1, start, observations)}: "
                f"only head {head} moves by {moved * in_counts:.0f} counts, "
                f"expected about {expected[alone[0]] * in_counts:.0f} (within 10 %); "
                f"{alone.size} such steps in this run"
            )
    return found


def _frozen(step_counts: Float, other_counts: Float) -> list[tuple[int, int]]:
    """Return the first row and the number of further rows of each stretch in which a head keeps its
    count while another head moves as usual.

    A stretch has more than MOST_SLIPS steps. A head with more than MOST_SLIPS such stretches has
    coarser counts than the other.
    """
    usual = float(np.median(np.abs(other_counts)))
    if usual < LEAST_MOVE_COUNTS:
        return []
    still = (np.abs(step_counts) < 0.5) & (np.abs(other_counts) > 0.5 * usual)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    found = [
        (first, after - first)
        for first, after in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
        if after - first > MOST_SLIPS
    ]
    return found if len(found) <= MOST_SLIPS else []


def _expected_step(step: Float, passed_s: Float | None) -> Float:
    """Return the expected step of each row: the median of the steps around it. With ``passed_s``,
    the expected step is the median speed around the row times the time that passed."""
    if passed_s is None:
        return np.asarray(median_filter(step, size=AROUND_ROWS, mode="nearest"))
    usual_s = float(np.median(passed_s[passed_s > 0.0]))
    length = np.where(passed_s > 0.0, passed_s / usual_s, 1.0)
    return np.asarray(median_filter(step / length, size=AROUND_ROWS, mode="nearest") * length)


def _place(sample: int, start: int, observations: Observations) -> str:
    return f"sample {sample} of the run ({_row(observations.sample_line(start + sample))})"


def _row(line: int) -> str:
    return f"row {line - 2} of the data, line {line} of the file"


def _implausible(step: Float, passed_s: Float) -> Boolean:
    """Return True where a step differs from the steps around it, and also from the speed around it
    times the time between the rows.

    Time stamps may be coarser than the rows, and rows may be missing, so that a step that agrees
    with one of the two is correct.
    """
    lowest, highest = float(step.min()), float(step.max())
    if highest - lowest <= STEP_TOLERANCE * min(abs(lowest), abs(highest)) and lowest * highest > 0:
        # A median of these steps lies between the smallest and the largest of them, so that no step
        # can exceed the tolerance.
        return np.zeros(step.size, dtype=bool)
    noise = LOST_SIGMA * step_scatter(step)
    wrong = np.ones(step.size, dtype=bool)
    for passed in (None, passed_s):
        expected = _expected_step(step, passed)
        wrong &= np.abs(step - expected) > np.maximum(STEP_TOLERANCE * np.abs(expected), noise)
        if not wrong.any():
            break
    return wrong


def _temperature_faults(
    channel: str, temperature_c: Float | None, used: Integer | None
) -> list[str]:
    if temperature_c is None:
        return []
    low, high = TEMPERATURES_C
    outside = np.flatnonzero((temperature_c < low) | (temperature_c > high))
    if outside.size:
        return [
            f"{channel}, {_row(file_line(used, int(outside[0])))}: temperature_c is "
            f"{temperature_c[outside[0]]:g}, expected {low:g} to {high:g} °C; {outside.size} such "
            "rows"
        ]
    spikes = excursions(temperature_c, TEMPERATURE_JUMP_K)
    if not spikes:
        return []
    first, _, size = spikes[0]
    return [
        f"{channel}, {_row(file_line(used, first))}: temperature_c changes by {size:+.1f} K and "
        f"back within three rows; {len(spikes)} such places"
    ]


def cut_runs(observations: Observations) -> list[str]:
    """Return a warning for each run that is cut, while the other runs have whole turns.

    Such a run is used: its rows are as good as those of the other runs. :func:`too_short` concerns
    runs of less than one turn.
    """
    found: list[str] = []
    for rows in observations.pairs()[:1]:
        ends = _ends(rows)
        whole = np.abs(ends.turns - np.round(ends.turns)) < WHOLE_TURN_TOLERANCE
        if ends.turns.size > 2 and whole.sum() >= ends.turns.size - 1:
            found += [
                f"capture, run {run}: cut after {ends.turns[run]:.3f} turns; the other runs have "
                "whole turns; all rows of the run are used, but a calibration uses its whole turns "
                "only"
                for run in np.flatnonzero(~(whole | ends.short | ends.ends_in_gap)).tolist()
            ]
    return found


def too_short(observations: Observations) -> str | None:
    """Return the reason why a capture with runs of less than one turn determines no model; None
    for a capture without such runs.

    Such runs among runs of whole turns were left out before
    (:func:`~arctrue.workbench.observations.run_turns.rows_of_short_runs`).
    """
    for rows in observations.pairs()[:1]:
        ends = _ends(rows)
        turns = ends.turns[ends.too_short]
        if turns.size == 0:
            return None
        several = f"{turns.size} of the {ends.turns.size} runs have" if turns.size > 1 else "run "
        if turns.size == 1:
            several += f"{int(np.flatnonzero(ends.too_short)[0])} has"
        return (
            f"in the capture {several} {_range(turns)} of a turn, and the difference of two heads "
            "determines the orders of the disc only over a whole turn"
        )
    return None


def _range(turns: Float) -> str:
    low, high = (f"{value:.3f}" for value in (turns.min(), turns.max()))
    return low if low == high else f"{low} to {high}"


def _ends(rows: CaptureRows | StoredCapture) -> RunEnds:
    return run_ends(rows.angle_rad / (2.0 * np.pi), run_spans(rows.run))
