"""Calculates the speed of the table in each row of a capture from its angle and the time stamps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

WINDOW_ROWS = 65
"""Number of rows, odd, from which a local speed is calculated: 65 ms at the paper's sampling
rate."""
EVEN = 0.01
"""Largest relative deviation of the local speed from the mean speed in a run that turns evenly."""
NOISE_FACTOR = 6.0
"""A run also turns evenly if the deviation is within this number of standard deviations of the
local speed's noise."""


@dataclass(frozen=True)
class RunSpeeds:
    """Signed speeds, rad/s: the mean speed of each run, (runs,), and the speed of each row if
    speeds within a run differ."""

    mean_rad_s: Float
    local_rad_s: Float | None
    """Speed of each row, (rows,); None if every run turns evenly."""

    def of(self, run: Integer, rows: slice | Integer) -> Float:
        """Return the speed of the given rows; ``run`` is the run of each row."""
        if self.local_rad_s is None:
            return self.mean_rad_s[run]
        return self.local_rad_s[rows]

    def in_channels(self, channels: int, sample: Integer) -> RunSpeeds:
        """Return the speeds of rows that repeat each run in several channels; ``sample`` is the
        sample of each row."""
        local = self.local_rad_s
        return RunSpeeds(
            np.repeat(self.mean_rad_s, channels), None if local is None else local[sample]
        )

    def every(self, channels: int, rows: Integer) -> RunSpeeds:
        """Return the speeds of one channel whose rows are ``rows``: the inverse of
        :meth:`in_channels`."""
        local = self.local_rad_s
        return RunSpeeds(self.mean_rad_s[::channels], None if local is None else local[rows])


def run_speeds(
    angle_rad: Float, time_s: Float, spans: Sequence[tuple[int, int]], angle_noise_rad: float
) -> RunSpeeds:
    """Return the speeds of the runs in ``spans``.

    ``angle_noise_rad``: standard deviation of one angle. The local speed of a row is the
    least-squares slope of the angle over the time of the rows around it. In a run that turns
    evenly, and in a run of fewer than 2·WINDOW_ROWS rows, every row gets the mean speed of the run.
    A local speed would only add noise to the columns that depend on the speed.
    """
    mean = np.zeros(len(spans))
    local: Float | None = None
    for number, (start, end) in enumerate(spans):
        angle, time = angle_rad[start:end], time_s[start:end]
        duration = float(time[-1] - time[0])
        mean[number] = float(angle[-1] - angle[0]) / duration if duration > 0.0 else 0.0
        if duration <= 0.0 or angle.size < 2 * WINDOW_ROWS:
            continue
        slope, noise = _local_slope(time, angle, angle_noise_rad)
        swing = float(np.abs(slope - mean[number]).max())
        if swing <= max(EVEN * abs(mean[number]), NOISE_FACTOR * noise):
            continue
        if local is None:
            local = np.concatenate([np.full(last - first, np.nan) for first, last in spans])
        local[start:end] = slope
    if local is not None:
        for number, (start, end) in enumerate(spans):
            if np.isnan(local[start]):
                local[start:end] = mean[number]
    return RunSpeeds(mean, local)


def _local_slope(time: Float, angle: Float, angle_noise_rad: float) -> tuple[Float, float]:
    """Return the slope over WINDOW_ROWS rows around each row, and its largest uncertainty."""
    half = WINDOW_ROWS // 2
    t = time - time[0]
    # The mean motion is subtracted from the angle, so that the sums keep their digits.
    mean = (angle[-1] - angle[0]) / t[-1]
    rest = angle - angle[0] - mean * t

    def windowed(values: Float) -> Float:
        total = np.concatenate([[0.0], np.cumsum(values)])
        return np.asarray(total[WINDOW_ROWS:] - total[:-WINDOW_ROWS])

    # Times count from the middle of the run, also so that the sums keep their digits.
    centred = t - 0.5 * t[-1]
    n = float(WINDOW_ROWS)
    s1, s2 = windowed(centred), windowed(centred * centred)
    y1, xy = windowed(rest), windowed(centred * rest)
    spread = np.maximum(s2 - s1 * s1 / n, 1e-30)
    slope = mean + (xy - s1 * y1 / n) / spread
    slope = np.concatenate([np.full(half, slope[0]), slope, np.full(half, slope[-1])])
    return slope, angle_noise_rad / float(np.sqrt(spread.min()))
