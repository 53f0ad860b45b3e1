"""Fits a noise of kernel parts to rows by maximum likelihood, from several starts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from arctrue.workbench.noise.kernel import (
    KernelFactor,
    KernelNoise,
    Part,
    with_slopes,
)

Float = NDArray[np.float64]

SMALLEST, LARGEST = 1e-8, 1e3
"""Limits of a part's variance, in variances of the rows. The upper limit is large, because the
stationary variance of a random walk is far above the variance of the rows in a record."""
SHORTEST_STEPS = 0.5
"""Lower limit of a decay time, in median steps of the clock."""
LONGEST_SPANS = 10.0
"""Upper limit of an exponential's decay time, in lengths of the longest stretch of successive rows;
at the limit the noise is nearly a random walk. The upper limit of a smooth part is one such length.
"""
OSCILLATOR_SPANS = 0.25
"""Longest decay time of an oscillator, in lengths of the longest stretch; an oscillation that
decays more slowly counts as a steady oscillation, a line of the spectrum.
"""
SMOOTH_MUST_GAIN = 2.0
"""Gain in log likelihood that smooth noise needs over two exponentials. Both kinds of noise have
the same number of parameters; smooth noise replaces two exponentials, the simpler noise, only at
odds of 7 to 1."""
ENOUGH = 0.01
"""The search ends when a step gains less log likelihood than this."""
STEPS = 60
"""Largest number of steps of the optimiser; ENOUGH ends them earlier."""
MOST_KEPT = 512
"""Largest number of fits that are kept, each a few hundred bytes; the search in one record makes
about a hundred (counted on records of 2,000 to 4,000 rows)."""
MOST_FREE = 5
"""Largest number of columns of a noise whose parts are all fitted: an exponential, a smooth part,
an oscillator. With more than four columns, the derivatives are calculated by differences, which
takes three times as long."""


@dataclass(frozen=True, eq=False)
class Rows:
    """The rows that the noise is fitted to: a clock, readings per row, and the values of each
    row."""

    clock: Float
    """Clock of the rows, shape (rows,), which increases."""
    readings: Float
    """Number of readings in the mean of each row."""
    values: Float
    """Measured values in the first column, then the columns that are fitted to them, shape (rows, 1
    + k)."""
    step: float
    span: float
    """Length of the longest stretch, in the unit of the clock."""

    def factor(self, noise: KernelNoise) -> KernelFactor:
        """Factor the covariance of the rows."""
        return KernelFactor(self.clock, self.readings, noise)

    def digest(self, start: KernelNoise) -> bytes:
        """Return a hash of all numbers that a fit from ``start`` uses."""
        found = blake2b(repr((self.values.shape, self.step, self.span, start)).encode())
        for values in (self.clock, self.readings, self.values):
            found.update(np.ascontiguousarray(values).data)
        return found.digest()

    def left(self) -> Float:
        """Return the measured values minus their fit by the columns in plain least squares."""
        own, columns = self.values[:, 0], self.values[:, 1:]
        if columns.shape[1] == 0:
            return own
        return np.asarray(own - columns @ np.linalg.lstsq(columns, own, rcond=1e-10)[0])


@dataclass(frozen=True)
class KernelFit:
    """The most likely noise, and the likelihood of the rows with this noise."""

    noise: KernelNoise
    log_likelihood: float

    @property
    def score(self) -> float:
        """Log likelihood; for noise with a smooth part, SMOOTH_MUST_GAIN is subtracted."""
        return self.log_likelihood - (SMOOTH_MUST_GAIN if self.noise.smooth else 0.0)


_KEPT: dict[bytes, KernelFit] = {}
"""Latest fits: a diagnosis searches the same record again with another effect in the model."""


def fit_from(rows: Rows, start: KernelNoise) -> KernelFit:
    """Return the maximum of the likelihood that is reached from ``start``.

    In noise with more than MOST_FREE columns only the last part is fitted. The other parts stay
    fixed, because they were fitted before the last part was added. A fit of the same numbers is
    taken from the latest MOST_KEPT fits.
    """
    key = rows.digest(start)
    found = _KEPT.get(key)
    if found is None:
        found = _KEPT[key] = _searched_from(rows, start)
        for oldest in list(_KEPT)[:-MOST_KEPT]:
            _KEPT.pop(oldest, None)
    return found


def _searched_from(rows: Rows, start: KernelNoise) -> KernelFit:
    low, high = _limits(rows, start)
    whole = np.clip(start.logs, low, high)
    free = list(range(whole.size))
    if start.columns > MOST_FREE:
        free = free[-2:]
    begin, low, high = whole[free], low[free], high[free]

    def noise_at(logs: Float) -> KernelNoise:
        every = whole.copy()
        every[free] = logs
        return start.with_logs(every)

    known: dict[bytes, tuple[float, Float]] = {}

    def cost(logs: Float) -> tuple[float, Float]:
        # The tolerance, the optimiser and the result use the same costs.
        key = logs.tobytes()
        if key not in known:
            value, slopes = with_slopes(
                rows.clock, rows.readings, rows.values, noise_at(logs), free
            )
            known[key] = -value, -slopes
        value, slopes = known[key]
        return value, slopes.copy()

    scale = max(abs(cost(begin)[0]), 1.0)
    found = minimize(
        cost,
        begin,
        jac=True,
        method="L-BFGS-B",
        bounds=list(zip(low, high, strict=True)),
        options={"maxiter": STEPS, "ftol": ENOUGH / scale, "gtol": 0.02},
    )
    best = np.asarray(found.x)
    return KernelFit(noise_at(best), -cost(best)[0])


def best_fit(rows: Rows, starts: Iterable[KernelNoise]) -> KernelFit:
    """Return the fit with the highest score over several starts."""
    return best_of(fit_from(rows, start) for start in starts)


def best_of(fits: Iterable[KernelFit]) -> KernelFit:
    """Return the fit with the highest score; the score of smooth noise is reduced by
    SMOOTH_MUST_GAIN."""
    return max(fits, key=lambda found: found.score)


def usual_starts(rows: Rows) -> list[KernelNoise]:
    """Return two starts: two exponentials, and one exponential with a smooth part.

    The variances of the starts come from the scatter of neighbours and of all rows.
    """
    left = rows.left()
    whole = max(float(np.mean(left**2)), 1e-30)
    white = float(np.clip(0.5 * np.mean(np.diff(left) ** 2), 0.02 * whole, whole))
    usual_readings = float(np.median(rows.readings))
    slow = max(whole - white, 0.1 * whole)
    short = np.sqrt(rows.step * rows.span)
    fast, slower = short / 5.0, rows.span / 3.0
    return [
        KernelNoise(
            0.5 * white * usual_readings,
            (Part("exponential", 0.3 * slow, fast), Part("exponential", slow, slower)),
        ),
        KernelNoise(
            0.5 * white * usual_readings,
            (Part("exponential", 0.3 * slow, slower), Part("smooth", slow, 2.0 * short)),
        ),
    ]


def with_oscillator(
    noise: KernelNoise, rows: Rows, frequency: float, variance: float
) -> KernelNoise:
    """Return the noise with one more oscillator, which starts with this variance."""
    decay = OSCILLATOR_SPANS * rows.span / 2.0
    return KernelNoise(noise.white, (*noise.parts, Part("oscillator", variance, decay, frequency)))


def _limits(rows: Rows, start: KernelNoise) -> tuple[Float, Float]:
    variance = max(float(np.mean(rows.values[:, 0] ** 2)), 1e-30)
    usual_readings = float(np.median(rows.readings))
    low = [SMALLEST * variance * usual_readings]
    high = [LARGEST * variance * usual_readings]
    for part in start.parts:
        low += [SMALLEST * variance, SHORTEST_STEPS * rows.step]
        longest = LONGEST_SPANS
        if part.kind == "smooth":
            longest = 1.0
        elif part.kind == "oscillator":
            longest = OSCILLATOR_SPANS
        high += [LARGEST * variance, longest * rows.span]
    return np.log(low), np.log(high)
