"""Models stationary noise as a sum of decaying parts, and differentiates its likelihood.

A part has the covariance a·exp(−c·τ) or, with an angular frequency d, the covariance of an
oscillator driven by white noise, a·exp(−c·τ)·(cos dτ + (c/d)·sin dτ). A smooth part is the
critically damped oscillator, in which two exponentials of nearly the same rate approximate (1 +
λτ)·exp(−λτ): Matérn noise of order 3/2.

The covariance is semiseparable, so the time to compute a likelihood and its derivatives is
proportional to the number of rows (Foreman-Mackey et al., Astron. J. 154 (2017) 220; backward pass:
Foreman-Mackey, Res. Notes AAS 2 (2018) 31; library celerite2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from celerite2 import backprop, driver  # type: ignore[import-untyped]
from numpy.typing import NDArray

Float = NDArray[np.float64]
Kind = Literal["exponential", "smooth", "oscillator"]

NEARLY_EQUAL = 1.1
"""Ratio of the two exponential rates of a smooth part to λ: this factor for one rate, its inverse
for the other rate. The covariance differs from (1 + λτ)·exp(−λτ) by at most 0.003 of the variance
(largest difference over τ, both in closed form)."""
MOST_EXACT = 4
"""Largest number of columns of the semiseparable form for which the library's backward pass is
right. With more columns it differs from finite differences in every digit (celerite2 0.3.3)."""
DIFFERENCE = 1e-5
"""Change of a logarithm in a difference quotient."""
IMPOSSIBLE = -1e15
"""Log likelihood that is returned for a covariance that cannot be factored."""


@dataclass(frozen=True)
class Part:
    """One part of the noise: kind, variance (arcsec²), and decay time."""

    kind: Kind
    variance: float
    decay: float
    """Decay time 1/c or 1/λ, in the unit of the clock."""
    frequency: float = 0.0
    """Frequency of an oscillator, periods per unit of the clock."""


@dataclass(frozen=True)
class KernelNoise:
    """White noise of each row, and a sum of coloured parts."""

    white: float
    """Variance of a single reading, arcsec²."""
    parts: tuple[Part, ...] = ()

    @property
    def logs(self) -> Float:
        """Logarithms of the white variance, then of each part's variance and decay time."""
        values = [self.white]
        for part in self.parts:
            values += [part.variance, part.decay]
        return np.log(np.maximum(values, 1e-300))

    def with_logs(self, logs: Float) -> KernelNoise:
        """Return noise of the same kinds and frequencies with other variances and decay times."""
        values = np.exp(logs)
        parts = tuple(
            Part(part.kind, float(values[1 + 2 * at]), float(values[2 + 2 * at]), part.frequency)
            for at, part in enumerate(self.parts)
        )
        return KernelNoise(float(values[0]), parts)

    def without_oscillators(self) -> KernelNoise:
        """Return the noise without its oscillators."""
        parts = tuple(part for part in self.parts if part.kind != "oscillator")
        return KernelNoise(self.white, parts)

    @property
    def columns(self) -> int:
        """Number of columns of the semiseparable form."""
        return sum(1 if part.kind == "exponential" else 2 for part in self.parts)

    @property
    def smooth(self) -> bool:
        """True if one of the parts is smooth."""
        return any(part.kind == "smooth" for part in self.parts)


@dataclass(frozen=True)
class _Form:
    """The semiseparable form of a noise on a clock: rates c, and U and V of shape (rows,
    columns)."""

    rates: Float
    diagonal: Float
    left: Float
    right: Float


class KernelFactor:
    """The factors LDLᵀ of the covariance of some rows."""

    def __init__(
        self, clock: Float, readings: Float, noise: KernelNoise, *, derivatives: bool = False
    ) -> None:
        """Factor the covariance of rows at the times ``clock``.

        ``readings``: number of readings in the mean of each row, shape (rows,). With
        ``derivatives``, the states that the backward pass needs are kept, unless MOST_EXACT
        excludes this pass. Raises driver.LinAlgError where the covariance cannot be factored.
        """
        self.clock, self.readings, self.noise = clock, readings, noise
        form = _form(clock, readings, noise)
        self._form = form
        self._states: Float | None = None
        if not noise.parts:
            self._pivots, self._lower = form.diagonal, form.right
            return
        self._pivots, self._lower = np.empty_like(form.diagonal), np.empty_like(form.right)
        inside = (clock, form.rates, form.diagonal, form.left, form.right)
        if derivatives and form.rates.size <= MOST_EXACT:
            self._states = np.empty((*form.left.shape, form.rates.size))
            try:
                backprop.factor_fwd(*inside, self._pivots, self._lower, self._states)
            except backprop.LinAlgError as failed:
                raise driver.LinAlgError(str(failed)) from failed
        else:
            driver.factor(*inside, self._pivots, self._lower)

    @cached_property
    def _deviation(self) -> Float:
        return np.asarray(np.sqrt(self._pivots))

    @property
    def log_determinant(self) -> float:
        """Log determinant of the covariance."""
        return float(np.sum(np.log(self._pivots)))

    def whiten(self, values: Float) -> Float:
        """Apply D^(−1/2)·L⁻¹ to columns, shape (rows, k)."""
        deviation = self._deviation[:, np.newaxis]
        if not self.noise.parts:
            return np.asarray(values / deviation)
        found, form = np.empty(values.shape), self._form
        driver.solve_lower(
            self.clock, form.rates, form.left, self._lower, np.ascontiguousarray(values), found
        )
        found /= deviation
        return found

    def colour(self, white: Float) -> Float:
        """Apply L·D^(1/2) to independent normal numbers, shape (rows,); the result is a draw of the
        noise."""
        scaled = np.ascontiguousarray((white * self._deviation)[:, np.newaxis])
        if not self.noise.parts:
            return np.asarray(scaled[:, 0])
        form = self._form
        found = driver.matmul_lower(
            self.clock, form.rates, form.left, self._lower, scaled, scaled.copy()
        )
        return np.asarray(found[:, 0])


def log_likelihood(clock: Float, readings: Float, values: Float, noise: KernelNoise) -> float:
    """Return the log likelihood of the first column of ``values``; the other columns are fitted to
    the first.

    ``values`` has the shape (rows, 1 + k).
    """
    try:
        factor = KernelFactor(clock, readings, noise)
    except driver.LinAlgError:
        return IMPOSSIBLE
    left, _ = _fitted(factor.whiten(values))
    found = -0.5 * (float(left @ left) + factor.log_determinant)
    return found if np.isfinite(found) else IMPOSSIBLE


def with_slopes(
    clock: Float, readings: Float, values: Float, noise: KernelNoise, free: Sequence[int]
) -> tuple[float, Float]:
    """Return the log likelihood, and its derivatives with respect to the entries ``free`` of
    :attr:`KernelNoise.logs`.

    The coefficients have their most likely values, so that their change with the noise does not
    contribute to the derivatives.
    """
    chosen = np.asarray(free, dtype=np.int64)
    try:
        factor = KernelFactor(clock, readings, noise, derivatives=True)
    except driver.LinAlgError:
        return IMPOSSIBLE, np.zeros(chosen.size)
    left, coefficients = _fitted(factor.whiten(values))
    found = -0.5 * (float(left @ left) + factor.log_determinant)
    if not np.isfinite(found):
        return IMPOSSIBLE, np.zeros(chosen.size)
    residual = values[:, 0] - values[:, 1:] @ coefficients
    if factor._form.rates.size > MOST_EXACT:
        return found, _by_differences(clock, readings, residual, noise, chosen)
    return found, _slopes(factor, residual)[chosen]


def _fitted(whitened: Float) -> tuple[Float, Float]:
    """Return the whitened first column minus its fit by the other columns, and the coefficients of
    the fit."""
    own, columns = whitened[:, 0], whitened[:, 1:]
    if columns.shape[1] == 0:
        return own, np.zeros(0)
    normal, moment = columns.T @ columns, columns.T @ own
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    scaled = normal * np.outer(scale, scale)
    scaled[np.diag_indices_from(scaled)] += RIDGE
    coefficients = scale * np.linalg.solve(scaled, scale * moment)
    return own - columns @ coefficients, coefficients


RIDGE = 1e-11
"""Value that is added to the diagonal of the normal matrix after the matrix is scaled so that its
diagonal is 1. If two columns of the model are equal, each then gets half of the coefficient.
"""


def _form(clock: Float, readings: Float, noise: KernelNoise) -> _Form:
    shape = (clock.size, noise.columns)
    rates, left, right = np.empty(noise.columns), np.empty(shape), np.ones(shape)
    at, variance = 0, 0.0
    for part in noise.parts:
        rate = 1.0 / part.decay
        variance += part.variance
        if part.kind == "exponential":
            rates[at], left[:, at] = rate, part.variance
            at += 1
        elif part.kind == "smooth":
            for share, of_rate in _SMOOTH:
                rates[at], left[:, at] = rate * of_rate, part.variance * share
                at += 1
        else:
            turning = 2.0 * np.pi * part.frequency
            cosine, sine = np.cos(turning * clock), np.sin(turning * clock)
            ratio = rate / turning
            rates[at : at + 2] = rate
            left[:, at] = part.variance * (cosine + ratio * sine)
            left[:, at + 1] = part.variance * (sine - ratio * cosine)
            right[:, at], right[:, at + 1] = cosine, sine
            at += 2
    return _Form(rates, noise.white / readings + variance, left, right)


def _smooth_shares(ratio: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return (share of the variance, rate over λ) of both exponentials; the slope of their sum is 0
    at τ = 0."""
    apart = ratio - 1.0 / ratio
    return (ratio / apart, 1.0 / ratio), (-1.0 / (ratio * apart), ratio)


_SMOOTH = _smooth_shares(NEARLY_EQUAL)


def _slopes(factor: KernelFactor, residual: Float) -> Float:
    """Return the derivatives of −(½·Σz²/D + ½·Σlog D), z = L⁻¹·residual, with respect to the
    logarithms (backward pass)."""
    clock, readings, noise, form = factor.clock, factor.readings, factor.noise, factor._form
    if not noise.parts:
        variance = noise.white / readings
        return np.array([0.5 * float(np.sum(residual**2 / variance - 1.0))])
    rows, count = form.left.shape
    pivots, lower, states = factor._pivots, factor._lower, factor._states
    assert states is not None
    column = np.ascontiguousarray(residual[:, np.newaxis])
    solved, memory = column.copy(), np.empty((rows, count, 1))
    backprop.solve_lower_fwd(clock, form.rates, form.left, lower, column, solved, memory)
    z = solved[:, 0]
    by_z = np.ascontiguousarray((z / pivots)[:, np.newaxis])
    by_pivots = 0.5 / pivots - 0.5 * (z / pivots) ** 2
    like = form.left
    _, rates1, left1, by_lower, _ = backprop.solve_lower_rev(
        clock, form.rates, form.left, lower, column, solved, memory, by_z,
        np.zeros(rows), np.zeros(count), np.zeros_like(like), np.zeros_like(like),
        np.zeros_like(column),
    )  # fmt: skip
    _, rates2, by_diagonal, left2, _ = backprop.factor_rev(
        clock, form.rates, form.diagonal, form.left, form.right, pivots, lower, states,
        by_pivots, np.asarray(by_lower), np.zeros(rows), np.zeros(count), np.zeros(rows),
        np.zeros_like(like), np.zeros_like(like),
    )  # fmt: skip
    by_rates, by_left = np.asarray(rates1) + rates2, np.asarray(left1) + left2
    of_diagonal = float(np.sum(by_diagonal))
    found = [noise.white * float(np.sum(np.asarray(by_diagonal) / readings))]
    at = 0
    for part in noise.parts:
        rate = 1.0 / part.decay
        if part.kind == "exponential":
            by_variance = part.variance * (float(np.sum(by_left[:, at])) + of_diagonal)
            by_log_rate = rate * by_rates[at]
            at += 1
        elif part.kind == "smooth":
            by_variance, by_log_rate = part.variance * of_diagonal, 0.0
            for share, of_rate in _SMOOTH:
                by_variance += part.variance * share * float(np.sum(by_left[:, at]))
                by_log_rate += rate * of_rate * by_rates[at]
                at += 1
        else:
            both = slice(at, at + 2)
            by_variance = float(np.sum(by_left[:, both] * form.left[:, both]))
            by_variance += part.variance * of_diagonal
            # The factor c/d of the sine also grows with the rate c.
            cosine, sine = form.right[:, at], form.right[:, at + 1]
            ratio = rate / (2.0 * np.pi * part.frequency)
            by_ratio = part.variance * float(by_left[:, at] @ sine - by_left[:, at + 1] @ cosine)
            by_log_rate = rate * float(np.sum(by_rates[both])) + ratio * by_ratio
            at += 2
        found += [by_variance, -by_log_rate]
    return -np.array(found)


def _by_differences(
    clock: Float, readings: Float, residual: Float, noise: KernelNoise, free: NDArray[np.int64]
) -> Float:
    """Return the log likelihood's derivatives by one-sided differences, with fixed coefficients."""
    logs, column = noise.logs, residual[:, np.newaxis]
    here = log_likelihood(clock, readings, column, noise)
    found = np.empty(free.size)
    for at, index in enumerate(free):
        moved = logs.copy()
        moved[index] += DIFFERENCE
        there = log_likelihood(clock, readings, column, noise.with_logs(moved))
        found[at] = (there - here) / DIFFERENCE
    return found
