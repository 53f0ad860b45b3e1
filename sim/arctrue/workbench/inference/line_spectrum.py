"""Calculates the χ² that a line would remove from the residuals, at every order or frequency.

A line is a sinusoid with one phase for all rows of a channel, over the angle or over time.
C⁻¹·residual is summed in bins as wide as the median step of the rows, and its Fourier transform is
computed; the spectrum of the noise gives the information about a line. The result is accurate
enough for the start of a search.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.workbench.inference.channels import channel_rows, power_of_channels
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.observations.one_speed import coordinate

Float = NDArray[np.float64]

MOST_BINS = 1 << 22
"""Largest number of bins. A longer record is put into wider bins, and its fastest lines are not
searched."""
LEAST_PERIODS = 4.0
"""Fewest periods of a line in a record; with fewer periods it is a slow curve."""


@dataclass(frozen=True)
class LineSpectrum:
    """The spectrum of one channel, over the angle or over time."""

    rates: Float
    """Orders, 1/turn, or frequencies, Hz."""
    gain: Float
    """χ² that cos and sin of each rate would remove, approximately."""
    amplitude_arcsec: Float
    span: float
    """Length of the record, turns or seconds: two lines closer than 1/(2·span) count as one
    line."""
    lowest: float
    """Lowest rate of a line; lower rates are slow curves, which the offsets of the runs may
    cause."""

    @property
    def trials(self) -> float:
        """Number of independent rates in the spectrum."""
        if self.rates.size == 0:
            return 0.0
        return 2.0 * self.span * float(self.rates[-1] - self.rates[0])


def line_spectrum(residuals: Residuals, *, capture: bool, in_time: bool) -> LineSpectrum | None:
    """Return the spectrum of a channel; None without the channel, its noise, times or motion."""
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
    # MOST_BINS − 1 puts the last row, at the span itself, into the last of MOST_BINS bins, a power
    # of two.
    width = max(float(np.median(moved)), span / (MOST_BINS - 1))
    number = np.floor((place - place.min()) / width).astype(np.int64)
    length = int(number.max()) + 1
    padded = 1 << int(np.ceil(np.log2(2 * length)))
    spectra = [
        np.fft.rfft(np.bincount(number[part], weights=precise[part], minlength=length), padded)
        for part in channel_rows(rows)
    ]
    # A single spectrum is used directly: the square root of its square would differ by rounding.
    sums = np.abs(spectra[0]) if len(spectra) == 1 else np.sqrt(power_of_channels(spectra))
    rates = np.arange(sums.size) / (padded * width)
    # Each run of a capture has an offset of its own, so that a line must be visible within one run.
    lowest = LEAST_PERIODS / (_longest_run(place, rows.run) if capture else span)
    first = int(np.searchsorted(rates, lowest, side="right"))
    there = slice(first, int(np.searchsorted(rates, 0.5 / width)))
    rates, sums = rates[there], sums[there]
    information = _information(rates, place, noise, in_time=in_time)
    amplitude = np.divide(2.0 * sums, information, out=information)
    return LineSpectrum(rates, amplitude * sums, amplitude, span, lowest)


def _longest_run(place: Float, run: NDArray[np.int64]) -> float:
    """Return the distance in angle or time between the ends of the longest run."""
    return max(float(np.ptp(place[start:end])) for start, end in run_spans(run))


def _information(rates: Float, place: Float, noise: RowNoise, *, in_time: bool) -> Float:
    """Return Σ over the rows of 1/(spectral density of the noise) at each rate, arcsec⁻²."""
    rows_of_spectrum: dict[tuple[int, float, float], float] = {}
    spectra = {id(spectrum): spectrum for spectrum in noise.spectra}
    for part, spectrum in zip(noise.stretches, noise.spectra, strict=True):
        if part.stop - part.start < 2:
            continue
        step = noise.step(part)
        way = 1.0
        if not in_time:
            way = float(np.median(np.abs(np.diff(place[part])))) / max(step, 1e-300)
        # Stretches of a run have the same spectrum, step and speed, apart from rounding.
        key = (id(spectrum), float(f"{step:.9g}"), float(f"{way:.9g}"))
        rows = (part.stop - part.start) / noise.mean_square_scale(part)
        rows_of_spectrum[key] = rows_of_spectrum.get(key, 0.0) + rows
    total = np.full(rates.size, 1e-30)
    for (spectrum_id, step, way), rows in rows_of_spectrum.items():
        density = spectra[spectrum_id].density(rates if way == 1.0 else rates * way, step)
        total += np.divide(rows, density, out=density)
    return total
