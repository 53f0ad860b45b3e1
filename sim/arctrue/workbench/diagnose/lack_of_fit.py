"""Tests for lack of fit: compares whitened residuals with the scatter of repeated rows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations import CaptureRows, ReferenceRows
from arctrue.workbench.observations.stations_a_turn import stations_a_turn

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

LACK_OF_FIT = 1e-4
"""A lack of fit is sure if its p is below this value."""
LEAST_EXCESS = 0.25
"""A model is not adequate if its residuals exceed the noise by at least this share of the noise and
its lack of fit is significant, even if no effect describes the residuals."""
ANGLE_BINS = 120
"""Number of bins, of 3° each: six for each period of the paper's 20th order."""
ELECTRICAL_BINS = 24
"""Number of bins, of 15° each: six for each period of the fourth harmonic, the highest that
interpolation causes."""
LEAST_ROWS_A_GROUP = 3
"""Smallest number of rows in a group: two rows show a scatter, and a third row shows which of them
is wrong."""
LEAST_ROWS_A_PERIODOGRAM = 64
"""Least number of rows, which gives 31 frequencies. With fewer rows, Fisher's test finds only lines
that the means by angle also show."""

ROUNDING = 1e-6
"""Largest whitened residual, in standard deviations of the noise, that counts as rounding error
only. A model with as many coefficients as rows leaves such residuals; their pattern says nothing
about the fit. The numbers have 53 bits: an error a million times the noise is rounded to 1e-10 of
the noise."""


def analysis_of_variance(values: Float, group: Integer) -> float:
    """Return p of the F test: the probability that the scatter within the groups causes such
    differences of their means."""
    _, group = np.unique(group, return_inverse=True)
    counts = np.bincount(group)
    kept = counts >= LEAST_ROWS_A_GROUP
    inside = kept[group]
    values, group = values[inside], group[inside]
    if values.size == 0:
        return 1.0
    _, group = np.unique(group, return_inverse=True)
    counts = np.bincount(group).astype(np.float64)
    groups = counts.size
    if groups < 2 or values.size - groups < 4:
        return 1.0
    means = np.bincount(group, weights=values) / counts
    within = float(np.sum((values - means[group]) ** 2)) / (values.size - groups)
    between = float(np.sum(counts * (means - values.mean()) ** 2)) / (groups - 1)
    if within <= 0.0:
        return 1.0 if between <= 0.0 else 0.0
    return float(fdtrc(groups - 1, values.size - groups, between / within))


def line_in_time(rows: CaptureRows, residual: Float) -> float:
    """Return p of Fisher's test for one line in the periodogram of any run."""
    smallest, runs = 1.0, max(rows.runs, 1)
    for run in range(rows.runs):
        smallest = min(smallest, fisher_p(residual[rows.run == run]))
    return min(1.0, smallest * runs)


def fisher_p(values: Float) -> float:
    """Return p of Fisher's test for one line in the periodogram; 1 for too few values."""
    if values.size < LEAST_ROWS_A_PERIODOGRAM:
        return 1.0
    # Frequency 0 and, for an even number of values, the Nyquist frequency have no phase.
    phased = slice(1, (values.size + 1) // 2)
    power = np.abs(np.fft.rfft(values - values.mean())[phased]) ** 2
    share = float(power.max() / max(power.sum(), 1e-300))
    # This is the first term of Fisher's series for p; where p is small, the term is exact enough.
    log_p = np.log(power.size) + (power.size - 1) * np.log1p(-min(share, 1.0 - 1e-15))
    return float(np.exp(min(log_p, 0.0)))


def line_in_angle(rows: ReferenceRows, residual: Float) -> float:
    """Return p of Fisher's test along closely spaced stations, for each run and direction
    separately.

    Stations that never repeat have no scatter of repeats, but a line in their order spectrum still
    shows a lack of fit. A polygon has too few stations for this test; the analysis of variance
    tests them.
    """
    side = np.zeros(rows.run.size) if rows.direction is None else rows.direction
    passes = np.cumsum(np.diff(rows.run, prepend=rows.run[0]) != 0) * 2 + (side > 0)
    names = np.unique(passes)
    smallest = 1.0
    for name in names:
        inside = np.flatnonzero(passes == name)
        smallest = min(smallest, fisher_p(residual[inside]))
    return min(1.0, smallest * names.size)


def _is_rounding(residual: Float) -> bool:
    return bool(np.abs(residual).max(initial=0.0) < ROUNDING)


def _bins(angle_rad: Float, bins: int) -> Integer:
    place = np.floor(np.mod(angle_rad / (2.0 * np.pi), 1.0) * bins)
    return np.asarray(place, dtype=np.int64) % bins


def _capture_groupings(rows: CaptureRows) -> Iterator[Integer]:
    angle = _bins(rows.angle_rad, ANGLE_BINS)
    yield rows.run * ANGLE_BINS + angle
    yield rows.revolution * ANGLE_BINS + angle
    if rows.electrical1_rad is not None:
        yield _bins(rows.electrical1_rad, ELECTRICAL_BINS)
    if rows.electrical2_rad is not None:
        yield _bins(rows.electrical2_rad, ELECTRICAL_BINS)


def _reference_groupings(rows: ReferenceRows) -> Iterator[Integer]:
    station = np.round(np.mod(rows.target_rad, 2.0 * np.pi) * 1e4).astype(np.int64)
    side = np.zeros_like(station) if rows.direction is None else rows.direction.astype(np.int64)
    yield station * 4 + side
    yield side
    if rows.cycle is not None:
        yield rows.cycle
    yield np.arange(station.size) * 12 // max(station.size, 1)


def capture_lack_of_fit(residuals: Residuals) -> float | None:
    """Return the smallest p of all tests of the capture's rows, times the number of tests.

    The tests are groupings of the rows and a line in time; the result is None without a capture.
    """
    rows, residual = residuals.observations.capture, residuals.capture_whitened
    if rows is None or residual is None:
        return None
    if _is_rounding(residual):
        return 1.0
    found = [analysis_of_variance(residual, group) for group in _capture_groupings(rows)]
    found.append(line_in_time(rows, residual))
    return float(min(1.0, min(found) * len(found)))


def reference_lack_of_fit(residuals: Residuals) -> float | None:
    """Return the smallest p of all tests of the reference's rows, times the number of tests.

    The tests are groupings of the rows, the places against the scatter of the passes and, at
    closely spaced stations, a line in the angle; the result is None without a reference.

    The noise that whitens the residuals of the other tests includes a deviation that the model does
    not explain; the scatter of the passes does not include it.
    """
    rows, residual = residuals.observations.reference, residuals.reference_whitened
    if rows is None or residual is None:
        return None
    if _is_rounding(residual):
        return 1.0
    found = [analysis_of_variance(residual, group) for group in _reference_groupings(rows)]
    if residuals.visits is not None:
        found.append(residuals.visits.lack_of_fit_p)
    if stations_a_turn(rows) >= LEAST_ROWS_A_PERIODOGRAM:
        found.append(line_in_angle(rows, residual))
    return float(min(1.0, min(found) * len(found)))
