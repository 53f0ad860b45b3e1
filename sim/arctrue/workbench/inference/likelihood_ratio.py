"""Calculates the likelihood ratio of an effect; both models have their own noise estimates.

Noise that is estimated from residuals which still contain an effect contains the effect too: a slip
becomes slow noise, a reversal of a few rows becomes a correlation. For every effect that may be
named, the noise is therefore estimated once more with the effect in the model. The likelihoods of
the two models, each with its own best noise, are compared.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.inference.fit import ModelDesign, fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.score_test import Score
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.degrees_of_freedom import degrees_of_freedom
from arctrue.workbench.noise.fit import FIRST_ROUNDS, noise_of
from arctrue.workbench.noise.noise import Noise

MOST_ROUNDS = 3
"""Largest number of rounds of noise and coefficients; a round that gains little ends them
earlier."""
MUCH_MORE = 1.2
"""Factor by which a gain must rise with the new noise estimate to cause one more round."""


LEAST_MOVE = 1.0
"""If an effect changes a channel's residuals by a smaller χ² than this, the channel's noise is not
estimated anew. Such a change has the weight of one reading, and the noise is estimated from all
readings."""
Float = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SizeTest:
    """The test of an effect's size.

    It needs the covariance of the noise's variances, which costs more than the gain. Where search
    parameters or noises are compared, only the gain is used; the test is therefore made on first
    use.
    """

    base: Residuals
    effect: Effect
    nonlinear: Nonlinear
    score: Score

    @cached_property
    def freedom_and_index_share(self) -> tuple[float, float]:
        """Results of :func:`freedom_of_a_size`."""
        weights, offsets = self.base.projected(self.effect, self.nonlinear, self.score)
        return freedom_of_a_size(self.base, weights, offsets)


@dataclass(frozen=True)
class Evidence:
    """The evidence for one effect against the model without it."""

    gain: float
    """Twice the rise of the log likelihood; each of the two models has its own best noise."""
    score: Score
    """Score test with the noise that is estimated with the effect in the model."""
    base: Residuals
    """Residuals of the model without the effect, whitened with that noise."""
    size: SizeTest

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the noise variance in the test of the effect's size."""
        return self.size.freedom_and_index_share[0]

    @property
    def index_share(self) -> float:
        """Share of the index repeatability in the variance of the effect's size; near 1, the number
        of runs, not of rows, determines the degrees of freedom."""
        return self.size.freedom_and_index_share[1]


@dataclass(frozen=True)
class Null:
    """The model without the tested effect, with two estimates of its noise."""

    residuals: Residuals
    """Residuals with the noise that was estimated for this model."""
    search_walk: bool = True
    """Whether noise that contains a random walk is tried as well."""

    @cached_property
    def likelihood(self) -> float:
        """:func:`restricted_likelihood` of the residuals."""
        return restricted_likelihood(self.residuals)

    @cached_property
    def walk(self) -> Residuals:
        """Residuals with the noise that contains a random walk."""
        return with_a_walk(self.residuals)


def evidence(null: Null, effect: Effect, nonlinear: Nonlinear) -> Evidence:
    """Return the evidence for an effect."""
    residuals = null.residuals
    score = there = residuals.score(effect, nonlinear)
    base = residuals
    for _ in range(MOST_ROUNDS):
        before = there.gain
        grown = base.solution_with(effect, nonlinear, there)
        base = _with_noise(residuals, under(grown, base.solution))
        there = base.score(effect, nonlinear)
        if there.gain < MUCH_MORE * before:
            break
    found = evidence_with(base, null, effect, nonlinear)
    with_effect = null.likelihood + 0.5 * score.gain
    if with_effect <= restricted_likelihood(base) + 0.5 * there.gain:
        return found
    return replace(found, gain=_gain(with_effect, base, null, effect, nonlinear))


def evidence_with(base: Residuals, null: Null, effect: Effect, nonlinear: Nonlinear) -> Evidence:
    """Return the evidence for an effect; the model with the effect has the noise of ``base``.

    Any noise may be used, because the largest likelihood over all noise is at least the likelihood
    with this noise. The noise estimated with an effect may still absorb this effect as slow noise,
    while the noise estimated with another effect may not.
    """
    score = base.score(effect, nonlinear)
    with_effect = restricted_likelihood(base) + 0.5 * score.gain
    gain = _gain(with_effect, base, null, effect, nonlinear)
    return Evidence(gain, score, base, SizeTest(base, effect, nonlinear, score))


def _gain(
    with_effect: float, base: Residuals, null: Null, effect: Effect, nonlinear: Nonlinear
) -> float:
    """Return twice the rise of the log likelihood, from the best noise without the effect to the
    best noise with it; ``with_effect`` is one log likelihood with the effect."""
    without = max(restricted_likelihood(base), null.likelihood)
    if null.search_walk and with_effect > without:
        in_walk = restricted_likelihood(null.walk)
        without = max(without, in_walk)
        with_effect = max(with_effect, in_walk + 0.5 * null.walk.score(effect, nonlinear).gain)
    return max(2.0 * (with_effect - without), 0.0)


def with_a_walk(residuals: Residuals) -> Residuals:
    """Return the same model with the likeliest noise of a search that starts at a random walk.

    The likelihood hardly rises with the logarithm of a small variance, so that the usual search may
    miss a random walk. A slow effect then seems to be far more likely than noise.
    """
    base = residuals.solution
    left = base.capture_residual_arcsec(), base.reference_residual_arcsec()
    design = ModelDesign(base.terms, base.observations, base.context)
    noise = noise_of(design, left, base.noise, base.unknown_noise, rounds=FIRST_ROUNDS, walk=True)
    return _with_noise(residuals, noise)


def under(grown: Solution, base: Solution) -> Noise:
    """Estimate the noise from the residuals of ``grown``; the restricted likelihood uses the
    columns of ``base`` for both models, so that the two can be compared."""
    left = grown.capture_residual_arcsec(), grown.reference_residual_arcsec()
    design = ModelDesign(base.terms, base.observations, base.context)
    unmoved = base.unknown_noise | _unmoved(left, base)
    noise = noise_of(design, left, base.noise, unmoved)
    return noise.with_offsets(base.observations, grown.run_offsets_arcsec)


def _unmoved(left: tuple[Float | None, Float | None], base: Solution) -> frozenset[str]:
    """Return the channels in which an effect leaves residuals and noise almost unchanged."""
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
    """Fit the same model with only the white part of its noise; return the residuals."""
    return _with_noise(residuals, residuals.solution.noise.white_part())


def with_index_as_known(residuals: Residuals) -> Residuals:
    """Fit the same model with at most the index variance that was known before this set.

    The offsets of the set's own runs do not increase this variance, because the effect may have
    caused these offsets.
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
    """Return the log likelihood with the coefficients integrated out and the prior of the index
    variance included."""
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
