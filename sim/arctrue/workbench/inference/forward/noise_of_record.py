"""Estimates the noise of a record with lines in its model, and its local level: the power of the
whitened residuals at each frequency, divided by that of white noise."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record, orthonormal
from arctrue.workbench.inference.forward.tests_of_a_line import FAMILY_WISE
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import (
    KernelFit,
    Rows,
    best_fit,
    best_of,
    fit_from,
    usual_starts,
    with_oscillator,
)
from arctrue.workbench.noise.level import noise_level
from arctrue.workbench.noise.whiteness import whiteness

Float = NDArray[np.float64]

NOT_WHITE = 1e-4
"""If p of Ljung and Box is below this value, an oscillator is added to the noise before the search
for a line."""


def noise_with(record: Record, others: Float, near: KernelNoise | None = None) -> KernelFit:
    """Estimate the noise with ``others`` in the model, and with an oscillator if the residuals are
    not white."""
    rows = record.rows(others)
    starts = usual_starts(rows)
    if near is not None:
        starts.append(near.without_oscillators())
    fits = [fit_from(rows, start) for start in starts]
    found = best_of(fits)
    if whiteness_of(rows, found.noise) >= NOT_WHITE:
        return found
    wider = best_fit(rows, _with_resonance(rows, fits))
    # Variance, decay and frequency must each gain half a logarithm of the number of rows.
    worth = 1.5 * float(np.log(rows.clock.size))
    return wider if wider.score > found.score + worth else found


def _with_resonance(rows: Rows, fits: Iterable[KernelFit]) -> Iterator[KernelNoise]:
    """Yield each noise with one more oscillator, at the peak of its local level (`level_of`)."""
    variance = max(float(np.mean(rows.left() ** 2)) / 10.0, 1e-30)
    for fit in fits:
        noise = fit.noise
        if noise.smooth:
            # The exponential parts are omitted, because exact derivatives exist for few columns
            # only.
            parts = tuple(part for part in noise.parts if part.kind == "smooth")
            noise = KernelNoise(noise.white, parts)
        level = level_of(rows, fit.noise)
        frequency = float(level.frequency[int(np.argmax(level.excess))])
        yield with_oscillator(noise, rows, frequency, variance)


def whiteness_of(rows: Rows, noise: KernelNoise) -> float:
    """Return p of Ljung and Box for the whitened residuals.

    If their level changes with time, residuals and columns are divided by the local level.
    """
    left, columns = _whitened(rows, noise)
    found = whiteness(left, columns)
    if found is not None and found.autocorrelation_p < FAMILY_WISE:
        level = noise_level(left)
        if level is not None:
            found = whiteness(left / level.local, columns / level.local[:, np.newaxis])
    return 1.0 if found is None else found.autocorrelation_p


def whitened_left(rows: Rows, noise: KernelNoise) -> Float:
    """Return the whitened residuals of the rows' columns."""
    return _whitened(rows, noise)[0]


def _whitened(rows: Rows, noise: KernelNoise) -> tuple[Float, Float]:
    """Return the whitened residuals of the rows' columns, and the whitened columns."""
    whitened = rows.factor(noise).whiten(rows.values)
    own, columns = whitened[:, 0], whitened[:, 1:]
    return own - columns @ np.linalg.lstsq(columns, own, rcond=1e-10)[0], columns


@dataclass(frozen=True, eq=False)
class Level:
    """Local level of the noise: power of whitened residuals, divided by that of white noise."""

    frequency: Float
    """Frequencies, periods per unit of the clock."""
    excess: Float
    """Power ratio around each frequency; at least 1."""

    def at(self, record: Record, rate: float) -> float:
        """Return the factor by which the gain of a line at this rate is divided."""
        return float(np.interp(record.on_the_clock(rate), self.frequency, self.excess))

    def below(self, record: Record, rate: float) -> int:
        """Return the number of usable ordinates at frequencies below a rate."""
        return int(np.count_nonzero(self.frequency < record.on_the_clock(rate)))


def level_of(rows: Rows, noise: KernelNoise) -> Level:
    """Measure the local level of the noise; it is needed because a sum of noise parts cannot follow
    every shape of a spectrum.

    The level is the median of the periodogram of the whitened residuals over NEIGHBOURS ordinates,
    divided by the median for white noise, ln 2: a single line among them hardly changes the median.
    """
    left = whitened_left(rows, noise)
    power = np.abs(np.fft.rfft(left))[1:] ** 2 / left.size
    # A model of many orders absorbs the power at the frequencies of these orders: those ordinates
    # do not show the noise.
    shown = _shares_shown(rows) > HALF_SHOWN
    shown = shown if np.count_nonzero(shown) >= 3 else np.ones(power.size, dtype=bool)
    power = power[shown]
    wide = min(NEIGHBOURS, power.size // 2 * 2 - 1)
    edges = np.pad(power, wide // 2, mode="reflect")
    middle = np.median(np.lib.stride_tricks.sliding_window_view(edges, wide), axis=-1)
    frequency = np.arange(1, shown.size + 1)[shown] / (left.size * rows.step)
    return Level(frequency, np.maximum(middle / np.log(2.0), 1.0))


def _shares_shown(rows: Rows) -> Float:
    """Return the share of each periodogram ordinate that the columns of the rows leave.

    Shape (rows // 2,). The columns need not be orthonormal.
    """
    columns = orthonormal([rows.values[:, 1:]])
    taken = np.sum(np.abs(np.fft.rfft(columns, axis=0)[1:]) ** 2, axis=1) / columns.shape[0]
    # Normalised cosine and sine of one ordinate contribute half a unit each: together 1.
    return np.asarray(1.0 - np.minimum(taken, 1.0))


HALF_SHOWN = 0.5
"""An ordinate of the spectrum is used for the level if the columns of the model leave more than
this share of it."""
NEIGHBOURS = 41
"""Number of ordinates in the median; the level then scatters by 23 % (1/(√41·ln 2))."""
