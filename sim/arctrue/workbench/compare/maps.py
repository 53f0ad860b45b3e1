"""Maps the residual against one condition at a time: the means in bins of the condition, and the
share of the variance that these means explain."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations import CaptureRows, ReferenceRows
from arctrue.workbench.observations.column_unit import column_unit

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

ANGLE_BINS = 72
"""Number of bins in a turn, 5° each: 3.6 for each period of the paper's 20th order."""
PHASE_BINS = 24
"""Number of bins in a signal period: six for each period of the fourth harmonic, the highest that
interpolation causes."""
VALUE_BINS = 12
"""Number of bins over the range of a condition that has no period, a choice."""
NULL_DRAWS = 19
"""Number of draws of the noise; the probability that noise exceeds the largest of 19 draws is
1/20."""


@dataclass(frozen=True)
class ResidualMap:
    """Means of the residual in bins of one condition."""

    channel: str
    condition: str
    """Condition in words: angle, electrical phase of head 1, temperature, …"""
    unit: str
    centres: Float
    means_arcsec: Float
    standard_errors_arcsec: Float
    share: float
    """Share of the residual's variance that the means of the bins explain."""
    null_share: float
    """Largest share that the means of the bins explain in NULL_DRAWS draws of the fitted noise."""
    group: Integer = field(repr=False, compare=False)
    """Bin number of every row, shape (rows,)."""
    bins: int
    goes_round: bool = False
    """True for a condition that returns to its start: an angle or a phase."""

    @property
    def excess_share(self) -> float:
        """Share of the variance that the means explain; 0 if noise alone explains as much."""
        return self.share if self.share > self.null_share else 0.0


@dataclass(frozen=True)
class _Binning:
    condition: str
    unit: str
    group: Integer
    centres: Float
    goes_round: bool = False


def _angle(angle_rad: Float, bins: int, condition: str) -> _Binning:
    group = np.floor(np.mod(angle_rad / (2.0 * np.pi), 1.0) * bins).astype(np.int64) % bins
    return _Binning(condition, "deg", group, (np.arange(bins) + 0.5) * 360.0 / bins, True)


def _values(values: Float, condition: str, unit: str) -> _Binning | None:
    low, high = float(values.min()), float(values.max())
    if high - low <= 1e-9 * max(abs(low), abs(high), 1e-9):
        return None
    group = np.minimum(
        ((values - low) / (high - low) * VALUE_BINS).astype(np.int64), VALUE_BINS - 1
    )
    centres = low + (np.arange(VALUE_BINS) + 0.5) * (high - low) / VALUE_BINS
    return _Binning(condition, unit, group, centres)


def _labels(
    labels: Integer | NDArray[np.floating], condition: str, unit: str, *, goes_round: bool = False
) -> _Binning | None:
    names, group = np.unique(labels, return_inverse=True)
    if names.size < 2:
        return None
    return _Binning(condition, unit, group.astype(np.int64), names.astype(np.float64), goes_round)


def _capture_binnings(rows: CaptureRows) -> Iterator[_Binning | None]:
    yield _angle(rows.angle_rad, ANGLE_BINS, "angle")
    yield _labels(rows.run // rows.channels, "run", "1")
    if rows.channel is not None:
        yield _labels(rows.channel + 2, "head", "1")
    yield _labels(rows.revolution // rows.channels, "revolution", "1")
    yield _labels(rows.direction, "direction", "1")
    yield _labels(np.round(np.degrees(rows.speed_rad_s), 1), "speed", "deg/s")
    yield _values(rows.time_s, "time", "s")
    if rows.temperature_c is not None:
        yield _values(rows.temperature_c, "temperature", "°C")
    if rows.electrical1_rad is not None:
        yield _angle(rows.electrical1_rad, PHASE_BINS, "electrical phase of head 1")
    if rows.electrical2_rad is not None:
        yield _angle(rows.electrical2_rad, PHASE_BINS, "electrical phase of head 2")
    yield from _column_binnings(rows)


def _reference_binnings(rows: ReferenceRows) -> Iterator[_Binning | None]:
    if np.unique(np.round(rows.target_rad, 6)).size <= ANGLE_BINS:
        degrees = np.round(np.mod(np.degrees(rows.target_rad), 360.0), 4)
        yield _labels(degrees, "angle", "deg", goes_round=True)
    else:
        yield _angle(rows.target_rad, ANGLE_BINS, "angle")
    if rows.direction is not None:
        yield _labels(rows.direction, "direction", "1")
    if rows.cycle is not None:
        yield _labels(rows.cycle, "cycle", "1")
    yield _labels(rows.run, "run", "1")
    if rows.time_s is not None:
        yield _values(rows.time_s, "time", "s")
    if rows.temperature_c is not None:
        yield _values(rows.temperature_c, "temperature", "°C")
    if rows.speed_rad_s is not None:
        yield _labels(np.round(np.degrees(rows.speed_rad_s), 3), "speed", "deg/s")
    if rows.electrical1_rad is not None:
        yield _angle(rows.electrical1_rad, PHASE_BINS, "electrical phase of head 1")
    yield from _column_binnings(rows)


def _column_binnings(rows: CaptureRows | ReferenceRows) -> Iterator[_Binning | None]:
    for name, values in rows.conditions.items():
        yield _values(values, name, column_unit(name))


def variance_share(values: Float, group: Integer, bins: int) -> float:
    """Return the share of the sum of squares of ``values`` that the means of the groups explain."""
    total = float(values @ values)
    if total <= 0.0:
        return 0.0
    counts = np.maximum(np.bincount(group, minlength=bins), 1)
    sums = np.bincount(group, weights=values, minlength=bins)
    return float(np.sum(sums**2 / counts)) / total


def residual_maps(residuals: Residuals, random: np.random.Generator) -> list[ResidualMap]:
    """Return every map of both channels, sorted by ``excess_share``, the largest first."""
    found: list[ResidualMap] = []
    capture, reference = residuals.observations.capture, residuals.observations.reference
    noise = residuals.solution.noise
    drawn = [
        residuals.with_residuals(
            None if noise.capture is None else noise.capture.draw(random),
            None if noise.reference is None else noise.reference.draw(random),
        )
        for _ in range(NULL_DRAWS)
    ]
    if capture is not None and residuals.capture_arcsec is not None:
        centred = residuals.capture_arcsec - residuals.capture_arcsec.mean()
        nulls = [item.capture_arcsec for item in drawn if item.capture_arcsec is not None]
        found += _maps("capture", centred, nulls, _capture_binnings(capture))
    if reference is not None and residuals.reference_arcsec is not None:
        centred = residuals.reference_arcsec - residuals.reference_arcsec.mean()
        nulls = [item.reference_arcsec for item in drawn if item.reference_arcsec is not None]
        found += _maps("reference", centred, nulls, _reference_binnings(reference))
    return sorted(found, key=lambda item: -item.excess_share)


def _maps(
    channel: str, values: Float, nulls: list[Float], binnings: Iterator[_Binning | None]
) -> list[ResidualMap]:
    found = []
    for binning in binnings:
        if binning is None:
            continue
        bins = binning.centres.size
        counts = np.bincount(binning.group, minlength=bins)
        sums = np.bincount(binning.group, weights=values, minlength=bins)
        squares = np.bincount(binning.group, weights=values**2, minlength=bins)
        there = counts > 1
        means = sums[there] / counts[there]
        spread = np.sqrt(np.maximum(squares[there] / counts[there] - means**2, 0.0))
        found.append(
            ResidualMap(
                channel=channel,
                condition=binning.condition,
                unit=binning.unit,
                centres=binning.centres[there],
                means_arcsec=means,
                standard_errors_arcsec=spread / np.sqrt(counts[there]),
                share=variance_share(values, binning.group, bins),
                null_share=max(variance_share(null, binning.group, bins) for null in nulls),
                group=binning.group,
                bins=bins,
                goes_round=binning.goes_round,
            )
        )
    return found
