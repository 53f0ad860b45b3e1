"""Fits a spectrum to residuals, with stated priors, and calculates its uncertainty."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from arctrue.workbench.noise.likelihood import FixedTerms, RestrictedLikelihood, Stretch
from arctrue.workbench.noise.spectrum import Spectrum, time_constants

Float = NDArray[np.float64]
Cost = Callable[[Float], float]

PRIOR_CENTRE = 1e-3
"""Centre of the prior of a coloured part's variance, as a share of the variance of the rows."""
PRIOR_WIDTH = float(np.log(1e3))
"""Standard deviation of the variance's logarithm in this log-normal prior: a factor of a thousand
in either direction."""
SMALLEST, LARGEST = 1e-7, 30.0
"""Limits of a coloured part's variance, as shares of the variance of the rows."""
STATED_READINGS = 8.0
"""Weight of a stated uncertainty, as a number of readings."""
WALKS = (0.01, 0.1, 1.0, 10.0)
"""Variances of the slowest part in additional starts of the search, as shares of the variance of
the rows."""
ENOUGH = 0.01
"""The search ends when a step gains less log likelihood than this."""
MOST_KEPT = 24
"""Largest number of fits that are kept for the rows of a channel: about as many as one survey of
all effects makes."""
IMPOSSIBLE = 1e12
"""Cost of a spectrum whose covariance of the rows cannot be factored."""


@dataclass(frozen=True)
class WhiteBounds:
    """Lower bound and stated value of the white part's variance."""

    floor: float
    """Smallest variance, arcsec²: in a capture, the variance of the rounding to counts."""
    stated: float | None = None
    """Variance that the set states for a row, arcsec²."""


@dataclass(frozen=True)
class SpectrumFit:
    """The most likely spectrum and the covariance of the logarithms of its variances."""

    spectrum: Spectrum
    curvature: Callable[[], Float] = field(repr=False, compare=False)
    """Function that computes :attr:`covariance`; most fits never need it."""

    @cached_property
    def covariance(self) -> Float:
        """Covariance of log(white), log(aⱼ); shape (1 + parts, 1 + parts)."""
        return self.curvature()

    def __getstate__(self) -> dict[str, object]:
        """Return the content for pickle, with the covariance in place of the function."""
        covariance = self.covariance
        return {"spectrum": self.spectrum, "curvature": None, "covariance": covariance}


def _spectrum(logs: Float, constants: Float) -> Spectrum:
    values = np.exp(logs)
    return Spectrum(float(values[0]), constants, values[1:])


def fit_spectrum(
    stretches: Sequence[Stretch],
    fixed_terms: FixedTerms,
    white: WhiteBounds,
    *,
    start: Spectrum | None = None,
    rounds: int = 40,
    walk: bool = False,
    kept: dict[bytes, SpectrumFit] | None = None,
) -> SpectrumFit:
    """Return the spectrum at the maximum of the restricted likelihood times the priors.

    ``start`` is the spectrum of the same rows with another model; the search may start from it.
    With ``walk`` it also tries starts near a random walk. ``kept``: earlier fits; a fit of the same
    numbers is taken from them, because a diagnosis adds an effect to the same model more than once.
    """
    steps = np.concatenate([np.diff(stretch.clock) for stretch in stretches])
    step = float(np.median(steps)) if steps.size else 1.0
    span = max(float(np.ptp(stretch.clock)) for stretch in stretches)
    constants = time_constants(step, span) if start is None else start.constants
    likelihood = RestrictedLikelihood(stretches, step, constants, fixed_terms)
    residual = np.concatenate([stretch.residual for stretch in stretches])
    variance = max(float(np.mean(residual**2)), white.floor, 1e-12)
    if white.stated is not None and residual.size < STATED_READINGS:
        variance = max(variance, white.stated)
    begin = _from_scatter(stretches, constants, variance, white)
    low = np.log(np.full(begin.size, SMALLEST * variance))
    low[0] = np.log(max(white.floor, 1e-6 * variance))
    high = np.log(np.full(begin.size, LARGEST * variance))
    high[0] = max(high[0], low[0] + 1.0)
    centre = np.log(PRIOR_CENTRE * variance)

    def priors(logs: Float) -> tuple[float, Float]:
        away = (logs[1:] - centre) / PRIOR_WIDTH
        value, slopes = 0.5 * float(away @ away), np.concatenate([[0.0], away / PRIOR_WIDTH])
        if white.stated is not None:
            # The cost of the prior is that of ν readings with the stated variance u², if the white
            # variance is s²: ν/2·(log s² + u²/s²).
            share = white.stated * float(np.exp(-logs[0]))
            value += 0.5 * STATED_READINGS * (logs[0] + share)
            slopes[0] += 0.5 * STATED_READINGS * (1.0 - share)
        return value, slopes

    costs: dict[bytes, float] = {}

    def cost(logs: Float) -> float:
        # The choice of the start, the tolerance and the curvature use the same costs.
        key = logs.tobytes()
        if key not in costs:
            value = priors(logs)[0] - likelihood(_spectrum(logs, constants))
            costs[key] = value if np.isfinite(value) else IMPOSSIBLE
        return costs[key]

    def cost_with_gradient(logs: Float) -> tuple[float, Float]:
        value, slopes = priors(logs)
        found, by_variance = likelihood.with_gradient(_spectrum(logs, constants))
        if not np.isfinite(found):
            return IMPOSSIBLE, np.zeros(logs.size)
        return value - found, slopes - np.exp(logs) * by_variance

    begin = np.clip(begin, low, high)
    near = None
    if start is not None:
        near = np.log(np.maximum(np.concatenate([[start.white], start.variances]), 1e-300))
    asked = [constants, begin, low, high, near, np.array([centre])]
    key = likelihood.digest() + repr((white, rounds, walk)).encode()
    key += b"".join(b"-" if item is None else item.tobytes() for item in asked)
    if kept is not None and key in kept:
        return kept[key]
    if near is not None:
        # ``start`` is poor if it was fitted to residuals that contained an effect of the present
        # model. The search therefore starts from ``start`` or ``begin``, whichever has the lower
        # cost.
        begin = min(begin, np.clip(near, low, high), key=cost)
    if walk:
        begin = min(begin, *_with_a_walk(begin, variance, low, high), key=cost)
    found = minimize(
        cost_with_gradient,
        begin,
        jac=True,
        method="L-BFGS-B",
        bounds=list(zip(low, high, strict=True)),
        options={"maxiter": rounds, "ftol": ENOUGH / max(abs(cost(begin)), 1.0), "gtol": 0.05},
    )
    best = np.asarray(found.x)
    likelihood.forget()
    fit = SpectrumFit(_spectrum(best, constants), lambda: _covariance(cost, best))
    if kept is not None:
        while len(kept) >= MOST_KEPT:
            del kept[next(iter(kept))]
        kept[key] = fit
    return fit


def _from_scatter(
    stretches: Sequence[Stretch], constants: Float, variance: float, white: WhiteBounds
) -> Float:
    """Return the logarithms at which the search starts.

    The scatter of neighbours gives the white part; the remaining variance is divided evenly among
    the coloured parts.
    """
    changes = np.concatenate([np.diff(stretch.residual) for stretch in stretches])
    first = 0.5 * float(np.mean(changes**2)) if changes.size else variance
    first = min(max(first, 0.05 * variance, white.floor), variance)
    rest = max(variance - first, 0.0) / max(constants.size, 1) + PRIOR_CENTRE * variance
    return np.asarray(np.log(np.concatenate([[first], np.full(constants.size, rest)])))


def _with_a_walk(begin: Float, variance: float, low: Float, high: Float) -> list[Float]:
    """Return starts in which the slowest part has the variances WALKS; none without coloured parts.

    The likelihood hardly rises with the logarithm of a small variance, so a search that starts at a
    small variance ends there, even if a random walk is far more likely.
    """
    found = []
    for share in WALKS if begin.size > 1 else ():
        raised = begin.copy()
        raised[-1] = np.log(share * variance)
        found.append(np.clip(raised, low, high))
    return found


def _covariance(cost: Cost, best: Float) -> Float:
    """Return the inverse of the curvature, limited in each direction to the variance of the
    priors."""
    size, width = best.size, 0.1
    curvature = np.empty((size, size))
    around = {}

    def at(*moves: tuple[int, float]) -> float:
        moved = best.copy()
        for index, change in moves:
            moved[index] += change
        return float(cost(moved))

    here = at()
    for index in range(size):
        around[index] = (at((index, width)), at((index, -width)))
        curvature[index, index] = (sum(around[index]) - 2.0 * here) / width**2
    for first in range(size):
        for second in range(first):
            corner = at((first, width), (second, width))
            mixed = (corner - around[first][0] - around[second][0] + here) / width**2
            curvature[first, second] = curvature[second, first] = mixed
    values, vectors = np.linalg.eigh(curvature)
    values = np.maximum(values, PRIOR_WIDTH**-2)
    return np.asarray((vectors / values) @ vectors.T)
