"""Calculates the likelihood ratio of an effect, with the noise estimated anew on both sides.

Noise that is estimated from residuals which still contain an effect contains the effect too: a slip
becomes slow noise, a reversal of a few rows becomes a correlation. Therefore, for every effect that
may be named, the noise is estimated once more with the effect in the model, and the likelihoods of
the two models, each with its own best noise, are compared.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.inference.fit import ModelDesign, fit
from arctrue.workbench.inference.residuals import Residuals, Score
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.degrees_of_freedom import degrees_of_freedom
from arctrue.workbench.noise.fit import noise_of
from arctrue.workbench.noise.noise import Noise

MOST_ROUNDS = 3
"""Largest number of rounds of noise and coefficients; a round that gains little ends them
earlier."""
MUCH_MORE = 1.2
"""Factor by which a gain must rise with the new noise estimate to cause one more round."""


LEAST_MOVE = 1.0
"""χ² of the change of a channel's residuals. Below it, the channel's noise is not estimated anew:
such a change has the weight of one reading, and the noise is estimated from all readings."""
Float = NDArray[np.float64]


@dataclass(frozen=True)
class Evidence:
    """The evidence for one effect against the model without it."""

    gain: float
    """Twice the rise of the log likelihood, with the noise free on both sides."""
    freedom: float
    """Degrees of freedom of the noise variance in the test of the effect's size."""
    index_share: float
    """Share of the index repeatability in the variance of the effect's size; near 1, the runs are
    the sample."""
    score: Score
    """Score test with the noise that is estimated with the effect in the model."""
    base: Residuals
    """Residuals of the model without the effect, whitened with that noise."""


def evidence(
    residuals: Residuals, null_likelihood: float, effect: Effect, nonlinear: Nonlinear
) -> Evidence:
    """Return the evidence for an effect.

    ``null_likelihood`` is :func:`restricted_likelihood` of ``residuals``.
    """
    score = there = residuals.score(effect, nonlinear)
    base = residuals
    for _ in range(MOST_ROUNDS):
        before = there.gain
        grown = base.solution_with(effect, nonlinear, there)
        base = _with_noise(residuals, under(grown, base.solution))
        there = base.score(effect, nonlinear)
        if there.gain < MUCH_MORE * before:
            break
    likelihood = restricted_likelihood(base)
    with_effect = max(likelihood + 0.5 * there.gain, null_likelihood + 0.5 * score.gain)
    gain = 2.0 * (with_effect - max(likelihood, null_likelihood))
    freedom, share = freedom_of_a_size(base, *base.projected(effect, nonlinear, there))
    return Evidence(max(gain, 0.0), freedom, share, there, base)


def under(grown: Solution, base: Solution) -> Noise:
    """Estimate the noise from the residuals of ``grown``, in the contrasts to which the columns of
    ``base`` contribute nothing."""
    left = grown.capture_residual_arcsec(), grown.reference_residual_arcsec()
    design = ModelDesign(base.terms, base.observations, base.context)
    unmoved = base.unknown_noise | _unmoved(left, base)
    noise = noise_of(design, left, base.noise, unmoved)
    return noise.with_offsets(base.observations, grown.run_offsets_arcsec)


def _unmoved(left: tuple[Float | None, Float | None], base: Solution) -> frozenset[str]:
    """Return the channels in which an effect leaves the residuals, and so the noise, unchanged."""
    found = set()
    for channel, values, before, of_rows in (
        ("capture", left[0], base.capture_residual_arcsec(), base.noise.capture),
        ("reference", left[1], base.reference_residual_arcsec(), base.noise.reference),
    ):
        if values is None or before is None or of_rows is None:
            continue
        change = of_rows.whiten(values - before)
        if float(change @ change) < LEAST_MOVE:
            found.add(channel)
    return frozenset(found)


def without_slow_noise(residuals: Residuals) -> Residuals:
    """Return the residuals of the same model, fitted with the white part of the noise alone."""
    return _with_noise(residuals, residuals.solution.noise.white_part())


def with_index_as_known(residuals: Residuals) -> Residuals:
    """Return the same model, fitted with the index variance that was known before this set.

    An effect may have caused the offsets of the set's runs.
    """
    noise = residuals.solution.noise
    known = residuals.observations.index_sigma_arcsec**2
    noise = replace(noise, index_variance=min(known, noise.index_variance))
    return _with_noise(residuals, noise)


def _with_noise(residuals: Residuals, noise: Noise) -> Residuals:
    base = residuals.solution
    again = fit(base.terms, base.observations, base.context, noise=noise)
    return Residuals(replace(again, unknown_noise=base.unknown_noise))


def restricted_likelihood(residuals: Residuals) -> float:
    """Return the log likelihood with the coefficients integrated out and the index's prior
    included."""
    solution = residuals.solution
    noise = solution.noise
    prior = residuals.observations.index_sigma_arcsec**2
    total = solution.log_likelihood - 0.5 * residuals.log_determinant
    if residuals.observations.runs:
        total -= (
            0.5
            * noise.index_freedom
            * (float(np.log(noise.index_variance)) + prior / noise.index_variance)
        )
    return total


def freedom_of_a_size(
    residuals: Residuals, weights: tuple[Float | None, Float | None], offsets: Float
) -> tuple[float, float]:
    """Return the degrees of freedom of the noise in an effect's size, and the index's share in its
    variance.

    ``weights`` and ``offsets`` are results of :meth:`Residuals.projected`.
    """
    observations, noise = residuals.observations, residuals.solution.noise
    runs = {
        name: rows.run
        for name, rows in (("capture", observations.capture), ("reference", observations.reference))
        if rows is not None
    }
    return degrees_of_freedom(noise, weights, offsets, runs)
