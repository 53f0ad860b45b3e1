"""How much a line would take of the residuals, at every order per turn and every frequency.

One phase for all rows of a channel: a line that is fixed to the angle, or to time. Rows are put
into bins as wide as their median step, C⁻¹·residual is summed and transformed; what the noise
leaves of a line is told by its spectrum. Exact enough to find where to look.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.observations import CaptureRows, ReferenceRows

Float = NDArray[np.float64]

MOST_BINS = 1 << 22
"""A longer record is put into wider bins, and its fastest lines are not looked for."""
LEAST_PERIODS = 1.5
"""Fewer periods than these in the whole record are a slow curve, no line."""
SAME_PHASE_TURNS = 0.25
"""Angle and time are alike where, at one speed, they differ by less than this share of a period."""
LEAST_PASS_ROWS = 8


@dataclass(frozen=True)
class LineSpectrum:
    """Of one channel, over the angle or over time."""

    rates: Float
    """Orders, 1/turn, or frequencies, Hz."""
    gain: Float
    """What cos and sin of each rate would take of χ², about."""
    amplitude_arcsec: Float
    span: float
    """Length of the record, turns or seconds: lines nearer than 1/(2·span) are one."""

    @property
    def trials(self) -> float:
        """Number of independent places."""
        if self.rates.size == 0:
            return 0.0
        return 2.0 * self.span * float(self.rates[-1] - self.rates[0])


def line_spectrum(residuals: Residuals, *, capture: bool, in_time: bool) -> LineSpectrum | None:
    """None without the channel, its time or its noise, or where it shows no whole period."""
    rows = residuals.observations.capture if capture else residuals.observations.reference
    precise = residuals.capture_precise if capture else residuals.reference_precise
    noise = residuals.solution.noise.capture if capture else residuals.solution.noise.reference
    if rows is None or precise is None or noise is None or noise.weightless:
        return None
    place = coordinate(rows, in_time=in_time)
    if place is None:
        return None
    steps = np.abs(np.diff(place))[np.diff(rows.run) == 0]
    span = float(np.ptp(place))
    moved = steps[steps > 1e-9 * max(span, 1e-300)]
    if moved.size == 0:
        return None
    width = max(float(np.median(moved)), span / MOST_BINS)
    number = np.floor((place - place.min()) / width).astype(np.int64)
    length = int(number.max()) + 1
    padded = 1 << int(np.ceil(np.log2(2 * length)))
    sums = np.abs(np.fft.rfft(np.bincount(number, weights=precise, minlength=length), padded))
    rates = np.arange(sums.size) / (padded * width)
    there = (rates > LEAST_PERIODS / span) & (rates < 0.5 / width)
    rates, sums = rates[there], sums[there]
    told = _information(rates, place, noise, in_time=in_time)
    return LineSpectrum(rates, 2.0 * sums**2 / told, 2.0 * sums / told, span)


def coordinate(rows: CaptureRows | ReferenceRows, *, in_time: bool) -> Float | None:
    """Unwrapped angle in turns, or time in seconds, of every row; None where there is no time."""
    return rows.time_s if in_time else rows.angle_rad / (2.0 * np.pi)


def _information(rates: Float, place: Float, noise: RowNoise, *, in_time: bool) -> Float:
    """Σ over the rows of 1/(spectral density of the noise) at each rate, arcsec⁻²."""
    total = np.full(rates.size, 1e-30)
    for part, spectrum in zip(noise.stretches, noise.spectra, strict=True):
        if part.stop - part.start < 2:
            continue
        step = noise.step(part)
        way = 1.0
        if not in_time:
            way = float(np.median(np.abs(np.diff(place[part])))) / max(step, 1e-300)
        density = spectrum.density(rates * way, step)
        total += (part.stop - part.start) / (density * noise.mean_square_scale(part))
    return total


def speed_turns_s(rows: CaptureRows | ReferenceRows, highest_order: float) -> float | None:
    """The one speed of all passes, turns a second, at which an order and a frequency are the same.

    None where speeds differ, or there is no time, so that a line tells what it is fixed to. There
    and back at one speed, the phase of the way back is all that differs: it may be a lag.
    """
    turns, time_s = coordinate(rows, in_time=False), coordinate(rows, in_time=True)
    if turns is None or time_s is None or highest_order <= 0.0:
        return None
    speeds, durations = [], []
    for part in _passes(turns, rows.run):
        since = time_s[part] - time_s[part].mean()
        square = float(since @ since)
        if square <= 0.0:
            return None
        away = turns[part] - turns[part].mean()
        slope = float(since @ away) / square
        if float(np.abs(away - slope * since).max()) * highest_order > SAME_PHASE_TURNS:
            return None
        speeds.append(abs(slope))
        durations.append(float(np.ptp(time_s[part])))
    if not speeds or max(speeds) <= 0.0:
        return None
    apart = (max(speeds) - min(speeds)) * max(durations) * highest_order
    return float(np.median(speeds)) if apart < SAME_PHASE_TURNS else None


def _passes(turns: Float, run: NDArray[np.int64]) -> list[slice]:
    """Rows between changes of the run or of the sense of motion, LEAST_PASS_ROWS at least."""
    sense = np.sign(np.diff(turns))
    new = np.diff(run) != 0
    new[1:] |= (sense[1:] * sense[:-1] < 0.0) & ~new[:-1]
    bounds = [0, *(np.flatnonzero(new) + 1).tolist(), turns.size]
    return [slice(start, end) for start, end in pairwise(bounds) if end - start >= LEAST_PASS_ROWS]
