"""Computes the oracle's result for a cause: the part of the error that the base model cannot
absorb, compared with the noise.

The oracle uses the exact form of all causes, the noise process and the scatter of the index. The
oracle also fits 20 orders of the disc, an offset for each run and a zero of the reference. The
threshold of its test includes the look-elsewhere effect of a search for an order, a frequency or an
instant.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, isotonic_regression
from scipy.stats import chi2, ncx2

from arctrue.studies.benchmark.independent.causes.cause import Cause
from arctrue.studies.benchmark.independent.noise import NoiseProcess, StateNoise

Float = NDArray[np.floating[Any]]
BASE_ORDERS = 20
FALSE_ALARM, POWER = 0.01, 0.95
"""False-alarm probability and power of the oracle's test; both generators use these values."""
DEPENDENT = 1e-8
"""Ratio of a singular value of the scaled base to the largest one, below which the singular value
counts as zero."""
OSCILLATOR_PARAMETERS = 3
"""Number of parameters of a damped oscillator: size, frequency and quality."""
EXACT_INDEX_ARCSEC = 1e-6
"""Standard deviation that stands for an exactly repeating index; it holds the offset of each run at
zero."""


@dataclass(frozen=True)
class Channel:
    """Rows of one file (capture or reference), as arrays that the oracle uses."""

    name: str
    angle_rad: Float
    """Angle of head 1 in a capture, target angle in a reference."""
    time_s: Float
    noise: NoiseProcess
    run: NDArray[np.int64] | None
    """Number of the run of each row of a capture; None for a reference."""
    kept: NDArray[np.int64]
    """Indices, in the exact signal, of the rows that the file keeps."""
    separation_rad: float = 0.0

    def base(self) -> Float:
        """Return orders 1 to 20 in the form in which this channel measures them, (n, 40)."""
        here = _waves(self.angle_rad)
        if self.run is None:
            return here
        return _waves(self.angle_rad + self.separation_rad) - here


@dataclass(frozen=True, slots=True)
class Sight:
    """Result of the oracle for one cause."""

    noncentrality: float
    """Sum of squares, in units of the noise, of the part of the signal that neither the base
    columns nor the other causes absorb."""
    needed: float
    """Noncentrality at which the test, with a false-alarm probability of 1 %, finds the cause in 95
    % of such sets."""
    rms_arcsec: float
    """RMS of the part that the base does not absorb, in the channel where it is largest; the
    offsets of runs count too."""


@cache
def needed_noncentrality(columns: int, places: int) -> float:
    """Return the λ at which a noncentral χ² with ``columns`` degrees of freedom exceeds the
    threshold with probability POWER."""
    threshold = chi2.isf(FALSE_ALARM / places, columns)
    return float(brentq(lambda value: ncx2.sf(threshold, columns, value) - POWER, 1e-3, 1e5))


def look(
    channels: Sequence[Channel],
    alone: Sequence[Mapping[str, Float]],
    causes: Sequence[Cause],
    index_arcsec: float,
) -> list[Sight]:
    """Return the oracle's result for each cause; ``alone`` holds, for each cause, its own signal by
    channel."""
    if not causes:
        return []
    bases = [_base(channel, channels) for channel in channels]
    signals = [
        np.column_stack([signal[channel.name][channel.kept] for signal in alone])
        for channel in channels
    ]
    white = [
        channel.noise.whiten(np.column_stack([base, signal]), channel.time_s)
        for channel, base, signal in zip(channels, bases, signals, strict=True)
    ]
    width, runs = bases[0].shape[1], _runs(channels)
    held = np.zeros((runs, width + len(causes)))
    held[:, 2 * BASE_ORDERS : 2 * BASE_ORDERS + runs] = np.eye(runs) / max(
        index_arcsec, EXACT_INDEX_ARCSEC
    )
    rows = np.concatenate([*white, held])
    found = []
    for number, cause in enumerate(causes):
        others = [width + place for place in range(len(causes)) if place != number]
        nuisance = rows[:, [*range(width), *others]]
        scale = np.linalg.norm(nuisance, axis=0)
        scale[scale == 0] = 1.0
        signal = rows[:, width + number]
        absorbed = np.linalg.lstsq(nuisance / scale, signal, rcond=DEPENDENT)[0] / scale
        left = signal - nuisance @ absorbed
        moved = [0.0]
        for base, plain in zip(bases, signals, strict=True):
            rest = plain[:, number] - base @ absorbed[:width]
            moved.append(float(np.sqrt(np.mean(rest**2))))
        offsets = absorbed[2 * BASE_ORDERS : 2 * BASE_ORDERS + runs]
        if runs:
            moved.append(float(np.sqrt(np.mean(offsets**2))))
        found.append(
            Sight(float(left @ left), needed_noncentrality(cause.columns, cause.places), max(moved))
        )
    return found


def look_at_oscillators(channel: Channel) -> Sight | None:
    """Return the oracle's result for the damped oscillators in the noise of a channel.

    The rows are evenly spaced. The oracle uses the true spectrum of the noise and compares it with
    the nearest spectrum that never rises with frequency; white noise and relaxations have such
    spectra. The noncentrality is twice the mean log likelihood ratio (Whittle), summed over all
    runs. Returns None if the noise contains no oscillator.
    """
    noise = channel.noise
    if not noise.oscillators:
        return None
    assert isinstance(noise, StateNoise)
    runs = np.zeros(channel.time_s.size, np.int64) if channel.run is None else channel.run
    noncentrality, places = 0.0, 0
    for run in np.unique(runs):
        time_s = channel.time_s[runs == run]
        power = noise.mean_periodogram(time_s.size, float(np.median(np.diff(time_s))))
        # Among the spectra that never rise, the spectrum of greatest likelihood is the isotonic
        # regression (Barlow and Brunk).
        falling = isotonic_regression(power, increasing=False).x
        noncentrality += 2.0 * float(np.sum(np.log(falling / power)))
        places = max(places, power.size)
    rms = float(np.sqrt(sum(item.sigma_arcsec**2 for item in noise.oscillators)))
    return Sight(noncentrality, needed_noncentrality(OSCILLATOR_PARAMETERS, places), rms)


def _runs(channels: Sequence[Channel]) -> int:
    return sum(int(item.run.max()) + 1 for item in channels if item.run is not None)


def _base(channel: Channel, channels: Sequence[Channel]) -> Float:
    """Return the base columns: orders, offset of each run, zero of the reference, (n, 40 + runs +
    1)."""
    runs, rows = _runs(channels), channel.angle_rad.size
    offsets = np.zeros((rows, runs + 1))
    if channel.run is None:
        offsets[:, runs] = 1.0
    else:
        offsets[np.arange(rows), channel.run] = 1.0
    return np.column_stack([channel.base(), offsets])


def _waves(angle_rad: Float) -> Float:
    phase = angle_rad[:, None] * np.arange(1, BASE_ORDERS + 1)
    return np.column_stack([np.cos(phase), np.sin(phase)])
