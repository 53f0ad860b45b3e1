"""Faults of the data themselves, looked for before any effect is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.diagnose.outlying_rows import FAR_SIGMA, NORMAL_MAD, outlying, step_scatter
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows
from arctrue.workbench.observations.stored import StoredCapture

STEP_TOLERANCE = 0.1
"""A step is plausible within 10 % of its run's median."""
WHOLE_TURN_TOLERANCE = 0.02
"""A run whose turns are nearer than this to a whole number was meant to be whole turns."""
LOST_SIGMA = 8.0
"""Of the noise of a step, which in dense rows of few counts is more than that tenth."""
MOST_SLIPS = 8
"""A head that goes wrong more often than this in a run has not slipped: it does not follow."""
USUAL_LINES = 16_384
"""Where the set does not tell."""
HALF_PERIOD = 0.5
"""Of a signal period: what a reading can be off by and still come back to the same line."""
TEMPERATURES_C = (-60.0, 200.0)
TEMPERATURE_JUMP_K = 3.0
"""No sensor on a table goes so far and back within three rows."""
REFERENCE_JUMP_ARCSEC = 1.0
SEPARATION_DEG = 0.5
"""Half a millimetre at the disc; what a bracket is mounted off by is an effect."""
MOST_FOR_MEDIANS = 100_000
"""Rows, evenly spread, that a median over a long capture is taken of."""
LEAST_VISITS = 3


def data_faults(observations: Observations) -> list[str]:
    """What is wrong with the rows, in words: file, run, row, expected, found."""
    found: list[str] = []
    # Of a long capture all rows, not only the part that the statistics work on.
    rows = observations.capture if observations.stored is None else observations.stored
    if rows is not None:
        found += _separation_fault(rows, observations)
        spans = _run_spans(rows.run)
        for run, (start, end) in enumerate(spans):
            found += _step_faults(rows, run, start, end, observations)
        found += _cut_runs(rows, spans)
        found += _temperature_faults("capture", rows.temperature_c)
    if observations.reference is not None:
        found += _reference_faults(observations.reference)
        found += _temperature_faults("reference", observations.reference.temperature_c)
    return found


def _run_spans(run: NDArray[np.int64] | NDArray[np.int32]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(run)) + 1
    bounds = [0, *edges.tolist(), run.size]
    return list(pairwise(bounds))


def _separation_fault(rows: CaptureRows | StoredCapture, observations: Observations) -> list[str]:
    """Heads that stand elsewhere than the description says, by more than a mounting can be off."""
    thin = slice(None, None, max(rows.run.size // MOST_FOR_MEDIANS, 1))
    if isinstance(rows, StoredCapture):
        difference = rows.difference_rad(thin)
    else:
        difference = rows.difference_arcsec[thin] * (np.pi / 648_000.0)
    away_deg = float(np.degrees(np.median(difference)))
    nominal_deg = float(np.degrees(observations.head_separation_rad))
    if abs(away_deg) < SEPARATION_DEG:
        return []
    return [
        f"capture: head 2 reads {nominal_deg + away_deg:.3f}° ahead of head 1, expected "
        f"{nominal_deg:g}° within {SEPARATION_DEG:g}°; check head_separation_deg and "
        "counts_per_rev, which column is which head, and that both count from the index mark"
    ]


def _step_faults(
    rows: CaptureRows | StoredCapture, run: int, start: int, end: int, observations: Observations
) -> list[str]:
    if end - start < 3:
        return [f"capture, run {run}: only {end - start} samples"]
    step = np.diff(rows.angle_rad[start:end])
    if isinstance(rows, StoredCapture):
        difference = rows.difference_rad(slice(start, end))
    else:
        difference = rows.difference_arcsec[start:end] * (np.pi / 648_000.0)
    other = step + np.diff(difference)
    typical = float(np.median(step))
    if typical == 0.0:
        return [f"capture, run {run}: the table stands still"]
    if rows.time_s[end - 1] <= rows.time_s[start]:
        return [
            f"capture, run {run}: time_s stays at {rows.time_s[start]:g} s from the first row of "
            "the run to the last; expected the time of every sample"
        ]
    in_counts = (observations.counts_per_rev or 1) / (2.0 * np.pi)
    wrong = [_implausible(step, typical), _implausible(other, typical)]
    lost = wrong[0] & wrong[1]
    found = []
    if lost.any():
        first = int(np.flatnonzero(lost)[0])
        found.append(
            f"capture, run {run}, {_place(first + 1, start)}: both heads move by "
            f"{step[first] * in_counts:.0f} counts, expected about "
            f"{typical * in_counts:.0f} (within 10 %); {int(lost.sum())} such steps in this run"
        )
    # One head alone may slip: a step that stays is an effect. One that is back at once, and a
    # head that goes wrong again and again, are not.
    least_rad = HALF_PERIOD * 2.0 * np.pi / (observations.grating_lines or USUAL_LINES)
    spikes = [item for item in outlying(difference, least_rad) if not lost[item[0] - 1]]
    if spikes:
        first, _, size = spikes[0]
        head = 1 + int(abs(other[first - 1] - typical) > abs(step[first - 1] - typical))
        found.append(
            f"capture, run {run}, {_place(first, start)}: head {head} is off by "
            f"{abs(size) * in_counts:.0f} counts and back within three samples, while the other "
            f"goes on; {len(spikes)} such places in this run"
        )
        return found
    for head, bad in enumerate(wrong, start=1):
        alone = np.flatnonzero(bad & ~lost)
        if alone.size > MOST_SLIPS:
            moved = (step if head == 1 else other)[alone[0]]
            found.append(
                f"capture, run {run}, {_place(int(alone[0]) + 1, start)}: head {head} moves by "
                f"{moved * in_counts:.0f} counts while the other follows, expected about "
                f"{typical * in_counts:.0f} (within 10 %); {alone.size} such steps in this run"
            )
    return found


def _place(sample: int, start: int) -> str:
    return f"sample {sample} of the run ({_row(start + sample)})"


def _row(index: int) -> str:
    return f"row {index} of the data, line {index + 2} of the file"


def _implausible(step: NDArray[np.float64], typical: float) -> NDArray[np.bool_]:
    away = np.abs(step - typical)
    return np.asarray(away > max(STEP_TOLERANCE * abs(typical), LOST_SIGMA * step_scatter(step)))


def _temperature_faults(channel: str, temperature_c: NDArray[np.float64] | None) -> list[str]:
    if temperature_c is None:
        return []
    low, high = TEMPERATURES_C
    outside = np.flatnonzero((temperature_c < low) | (temperature_c > high))
    if outside.size:
        return [
            f"{channel}, {_row(int(outside[0]))}: temperature_c is "
            f"{temperature_c[outside[0]]:g}, expected {low:g} to {high:g} °C; {outside.size} such "
            "rows"
        ]
    spikes = outlying(temperature_c, TEMPERATURE_JUMP_K)
    if not spikes:
        return []
    first, _, size = spikes[0]
    return [
        f"{channel}, {_row(first)}: temperature_c goes {size:+.1f} K and back within "
        f"three rows; {len(spikes)} such places"
    ]


def _reference_faults(rows: ReferenceRows) -> list[str]:
    """Readings far from the other visits to their station, while those beside them are not."""
    station = np.round(np.mod(rows.target_rad, 2.0 * np.pi) * 1e6).astype(np.int64)
    _, group = np.unique(station, return_inverse=True)
    visits = np.bincount(group)
    if float(np.median(visits)) < LEAST_VISITS:
        return []
    order = np.argsort(group, kind="stable")
    bounds = np.concatenate([[0], np.cumsum(visits)])
    usual = np.array(
        [
            float(np.median(rows.error_arcsec[order[first:last]]))
            for first, last in pairwise(bounds.tolist())
        ]
    )
    away = rows.error_arcsec - usual[group]
    if np.any(visits < LEAST_VISITS):
        away = np.where(visits[group] < LEAST_VISITS, 0.0, away)
    scatter = NORMAL_MAD * float(np.median(np.abs(away - np.median(away))))
    least = max(REFERENCE_JUMP_ARCSEC, FAR_SIGMA * scatter)
    spikes = outlying(np.concatenate([[0.0], away, [0.0]]), least)
    if not spikes:
        return []
    first, _, _ = spikes[0]
    target_deg = np.degrees(rows.target_rad[first - 1])
    return [
        f"reference, {_row(first - 1)}: error_arcsec is {away[first - 1]:+.1f}″ from the "
        f"other readings at {target_deg:g}°, the rows beside it are not (their scatter is "
        f"{scatter:.2f}″); {len(spikes)} such places"
    ]


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
