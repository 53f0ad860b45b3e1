"""Calculates the noise of each channel from its own repeats: the scatter of rows at the same angle
or station.

No model can remove this scatter; it belongs to the set, not to the model. If a model describes a
deviation that does not repeat, such as a vibration, the residual can be smaller than the scatter;
the residual is then the noise.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.workbench.observations import CaptureRows, Observations

Float = NDArray[np.float64]

LARGEST_GAP_STEPS = 8.0
"""Two neighbouring rows have a gap between them if their distance is at least this number of median
steps of the run."""
_SAME_PHASE = 0.02
"""Largest phase difference of two rows that count as rows at one phase, as a share of a signal
period. A subdivision error differs between two such rows by at most 2π·0.02 of its amplitude."""
_MOST_ROWS_APART = 25
"""Largest distance, in rows, between the row one turn later and the row with the same phase."""
_LEAST_PAIRS = 50
"""Smallest number of differences: 50 differences determine the noise to 10 %."""


def row_noise_arcsec(
    observations: Observations, residual: Float, channel: str, rms_arcsec: float
) -> float:
    """Return the standard deviation of a row of ``capture`` or ``reference``, at most
    ``rms_arcsec``.

    ``rms_arcsec`` is the RMS of the residual in every row; ``residual`` may contain only a part of
    the rows.
    """
    if channel == "reference":
        return min(reference_noise_arcsec(observations, residual), rms_arcsec)
    # Each estimate contains errors that the other one excludes, and neither is below the noise. The
    # smaller one is therefore used.
    at_one_phase = _at_one_phase_arcsec(observations, residual)
    at_one_angle = capture_noise_arcsec(observations, residual)
    return min(at_one_angle, at_one_phase or at_one_angle, rms_arcsec)


def _at_one_phase_arcsec(observations: Observations, residual: Float) -> float | None:
    """Return the noise from rows of successive turns at nearly the same angle and the same signal
    phase.

    The result is None for too few rows. This estimate needs no interpolation. If rows are a signal
    period apart or more, an interpolated value would not contain the error within the signal
    period, and this error would count as noise.
    """
    rows = observations.capture
    assert rows is not None
    if rows.electrical1_rad is None:
        return None
    differences = [
        _turn_to_turn(rows, rows.electrical1_rad, residual, slice(first, last))
        for first, last in run_spans(rows.run)
    ]
    size = sum(item.size for item in differences)
    if size < _LEAST_PAIRS:
        return None
    square = sum(float(np.sum((item - item.mean()) ** 2)) for item in differences if item.size)
    runs = sum(item.size > 0 for item in differences)
    return float(np.sqrt(0.5 * square / (size - runs)))


def _turn_to_turn(rows: CaptureRows, electrical: Float, residual: Float, inside: slice) -> Float:
    """Return the differences of a run's rows from the rows of the same phase one turn earlier."""
    angle = rows.angle_rad[inside] * (1.0 if rows.direction[inside.start] > 0 else -1.0)
    phase, values = electrical[inside] / (2.0 * np.pi), residual[inside]
    ahead = angle + 2.0 * np.pi
    there = np.flatnonzero(ahead <= angle[-1])
    if not there.size or np.any(np.diff(angle) <= 0.0):
        return np.zeros(0)
    place = np.searchsorted(angle, ahead[there])
    found = np.full(there.size, -1)
    for apart in sorted(range(-_MOST_ROWS_APART, _MOST_ROWS_APART + 1), key=abs):
        later = np.clip(place + apart, 0, angle.size - 1)
        off = phase[later] - phase[there]
        same = np.abs(off - np.round(off)) <= _SAME_PHASE
        found = np.where((found < 0) & same & (later > there), later, found)
    pairs = found >= 0
    return np.asarray(values[found[pairs]] - values[there[pairs]])


def capture_noise_arcsec(observations: Observations, residual: Float) -> float:
    """Return the standard deviation of one row, from turn to turn at one angle within each run.

    The later turn is interpolated linearly at the angles of the earlier turn; at the fraction f of
    a step, the interpolated value has (1 − f)² + f² of a row's variance. For runs of a single turn,
    the differences from sample to sample are used.
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
        # If the part of a long capture has a gap, no row repeats the earlier row there.
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
    """Return the standard deviation of one row, from visit to visit of one station and direction.

    Successive visits are compared, so that a slow drift contributes little. With fewer than four
    repeated visits, neighbouring rows are compared.
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
