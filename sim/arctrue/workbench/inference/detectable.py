"""Calculates the smallest size of an effect that a set would show.

An effect is found if its gain passes the F test of :mod:`significance`, and if held-out rows show
it. An effect with very strong evidence (:class:`Refused`) is found even if held-out rows do not
show it. The power of these tests depends on one number, the noncentrality λ = s²·zᵀC⁻¹z of an
effect of form z and size s, C being the noise covariance. It follows from noncentral F and normal
distributions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import chdtrc, chdtri, chndtr, fdtr, gammaincinv, ncfdtr

from arctrue.workbench.effects.base import Effect, Nonlinear, Parameter
from arctrue.workbench.effects.capture_block import capture_block
from arctrue.workbench.inference.held_out import STANDARD_ERRORS
from arctrue.workbench.inference.likelihood_ratio import freedom_of_a_size
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.score_test import Score
from arctrue.workbench.inference.significance import MANY
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.numeric.distributions import f_limit

Float = NDArray[np.float64]

SIGNIFICANCE = 0.01
"""False alarm rate of the whole diagnosis, as in :data:`.significance.SIGNIFICANCE`."""
POWER = 0.95
"""Power of the tests at the stated size; the value is a choice. ``arctrue benchmark bound`` checks
whether the tests reach it."""
MOST_ROWS = 20_000
"""The mean square of a column is calculated from evenly spread rows of a longer capture; their
number is at least this value and less than twice this value."""
PROPORTIONAL = 1e-6
"""Relative tolerance of the test whether a parameter is a size: a size doubles when the
coefficients double."""
NOISE_DRAWS = 32
"""Number of quantiles that represent the unknown variance of the noise; with 64, λ changes by less
than 1 %."""
LARGE = 1e6
"""If the noncentrality is larger than this, the scatter of χ², 0.2 %, is neglected."""
FOLDS_SHARE = 4.0 / 3.0
"""Variance of a coefficient that is fitted to three of four folds, divided by its variance in a fit
to all rows."""


FEW_FREEDOM = 6.0
"""With fewer degrees of freedom than this, a detectable size is at least 2.8 times the size with
known noise. At this number and with one column among 19 effects, the detectable size is 14 standard
errors, in place of 5.1 with known noise; at 2, the fewest degrees of freedom, it is 188
(:func:`needed_gain`)."""


@dataclass(frozen=True)
class Refused:
    """Limits beyond which an effect is reported as unknown although held-out rows do not show
    it."""

    p: float
    """Largest corrected p of such an effect."""
    delta_bic: float
    """Smallest ΔBIC of such an effect."""
    trials: float = 1.0
    """Number of independent values that the effect's search tried; ΔBIC is reduced for them."""
    rows_by_themselves: float = 0.5
    """If the index repeatability causes this share or more of the variance of an effect's size,
    held-out rows are not used."""


@dataclass(frozen=True)
class Detectable:
    """A typical form of an effect, with its smallest detectable size."""

    rms_arcsec: dict[str, float]
    """RMS by channel, over the rows of the channel."""
    size: Parameter | None
    """Size in the effect's own unit; None where no parameter of the effect is a size."""
    freedom: float = float("inf")
    """Degrees of freedom of the noise variance on which the size is based."""

    @property
    def noise_hardly_known(self) -> bool:
        """Tell whether the size is far larger than it would be with known noise."""
        return self.freedom < FEW_FREEDOM


def needed_gain(rank: int, tests: float, freedom: float = np.inf) -> float:
    """Return the noncentrality at which a block of ``rank`` columns is found with 95 % power.

    The level is 1 %, divided by ``tests``: the number of candidates times the number of values that
    each search tried. ``freedom`` is the number of degrees of freedom of the noise variance.
    """
    return _powerful(rank, freedom, _threshold(rank, SIGNIFICANCE / max(tests, 1.0), freedom))


def _threshold(rank: int, p_value: float, freedom: float, gain: float = 0.0) -> float:
    """Return the threshold of χ² or F at which both the p value and a rise of the log likelihood by
    ``gain``/2 are reached."""
    if freedom > MANY:
        return max(float(chdtri(rank, p_value)), gain)
    of_gain = freedom / rank * float(np.expm1(gain / (freedom + rank)))
    return max(f_limit(p_value, rank, freedom), of_gain)


@lru_cache(maxsize=4096)
def _powerful(rank: int, freedom: float, threshold: float) -> float:
    """Return the noncentrality at which ``threshold`` is passed with 95 % power.

    The noise variance in λ is an estimate too, with the same degrees of freedom m: the power is its
    mean over draws in which λ is multiplied by χ²/m.
    """
    if freedom > MANY:
        return float(
            brentq(
                lambda gain: 1.0 - POWER - chndtr(threshold, rank, gain),
                1e-6,
                4.0 * threshold + 100.0,
            )
        )
    half = 0.5 * freedom
    levels = (np.arange(NOISE_DRAWS) + 0.5) / NOISE_DRAWS
    true_share = gammaincinv(half, levels) / half

    def missed(log_gain: float) -> float:
        of_draws = _not_passed(rank, freedom, np.exp(log_gain) * true_share, threshold)
        return float(np.mean(of_draws)) - (1.0 - POWER)

    low, high = 0.0, float(np.log(4.0 * rank * threshold + 100.0))
    while missed(high) > 0.0:
        high += 1.0
    return float(np.exp(brentq(missed, low, high, xtol=1e-4)))


def _not_passed(rank: int, freedom: float, gain: Float, threshold: float) -> Float:
    """Return the probability that noncentral F is below ``threshold``, for each noncentrality
    ``gain``.

    Scipy's series gives NaN at some noncentralities above about 1,000, and at all above about 10⁹.
    Patnaik's central F of the same first two moments (Biometrika 36 (1949) 202) replaces such
    values. Above LARGE, the numerator equals its mean to within 2/√LARGE, and the χ² of the
    denominator alone decides.
    """
    series = ncfdtr(rank, freedom, np.minimum(gain, LARGE), threshold)
    of_moments = (rank + gain) ** 2 / (rank + 2.0 * gain)
    central = fdtr(of_moments, freedom, threshold * rank / (rank + gain))
    series = np.where(np.isnan(series), central, series)
    by_mean = chdtrc(freedom, freedom * (rank + gain) / (rank * threshold))
    return np.asarray(np.where(gain > LARGE, by_mean, series))


def smallest_detectable(
    residuals: Residuals,
    effect: Effect,
    nonlinear: Nonlinear,
    tests: float,
    refused: Refused | None = None,
) -> Detectable | None:
    """Return the smallest size of an effect that the tests find in 95 % of such sets. The effect
    has the form of the typical column of its block: the column whose RMS at the noncentrality 1 is
    nearest to the median. The result is None where the model can explain the whole block. With
    ``refused`` the test on held-out rows counts too.
    """
    score = residuals.score(effect, nonlinear)
    if score.rank == 0:
        return None
    information = np.diag(score.information)
    there = information > 0.0
    # ``there`` excludes columns that the other columns of the block, or the model, explain
    # completely.
    units = np.where(there, 1.0 / np.sqrt(np.maximum(information, 1e-300)), 0.0)
    moved, typical = {}, int(np.flatnonzero(there)[0])
    for channel, columns in _columns(effect, nonlinear, residuals.solution):
        rms = units * np.sqrt(np.mean(columns**2, axis=0))
        if float(np.max(rms[there], initial=0.0)) > 0.0:
            moved[channel] = float(np.median(rms[there]))
            nearest = np.where(there, np.abs(rms - moved[channel]), np.inf)
            typical = int(np.argmin(nearest))
    form = np.zeros(units.size)
    form[typical] = units[typical]
    gain, freedom = _gain_of(
        residuals, effect, nonlinear, replace(score, coefficients=form), tests, refused
    )
    size = float(np.sqrt(gain))
    shown = {channel: size * rms for channel, rms in moved.items()}
    in_its_unit = _size(effect, nonlinear, size * units, typical, residuals)
    return Detectable(shown, in_its_unit, freedom)


def _gain_of(
    residuals: Residuals,
    effect: Effect,
    nonlinear: Nonlinear,
    form: Score,
    tests: float,
    refused: Refused | None,
) -> tuple[float, float]:
    """Return the noncentrality to which a form with noncentrality 1 must be scaled to be found, and
    the degrees of freedom."""
    weights, offsets = residuals.projected(effect, nonlinear, form)
    freedom, index_share = freedom_of_a_size(residuals, weights, offsets)
    gain = needed_gain(form.rank, tests, freedom)
    if refused is None or index_share >= refused.rows_by_themselves:
        return gain, freedom
    shown, rows = 0.0, 0
    for weight, precise in zip(
        weights, (residuals.capture_precise, residuals.reference_precise), strict=True
    ):
        if weight is not None and precise is not None and np.any(weight):
            # The error of the prediction of a row from its neighbours is C⁻¹r divided by the row's
            # precision, the diagonal of C⁻¹. The mean of the precision over the rows equals the
            # mean of (C⁻¹r)².
            shown += float(weight @ weight) / max(float(np.mean(precise**2)), 1e-300)
            rows += weight.size
    confirmed = held_out_gain(form.rank, shown)
    charged = form.rank * np.log(max(rows, 1)) + 2.0 * np.log(max(refused.trials, 1.0))
    level = refused.p / max(tests, 1.0)
    sure = _threshold(form.rank, level, freedom, refused.delta_bic + float(charged))
    return max(gain, min(confirmed, _powerful(form.rank, freedom, sure))), freedom


def held_out_gain(rank: int, shown: float) -> float:
    """Return the noncentrality at which held-out rows show an effect, with 95 % power.

    ``shown``: share of the effect that the neighbours of a row do not predict already. With the
    estimate ĉ from all rows, the log predictive density rises by ĉ²/2 minus the cost of four fits
    to three quarters of the rows. The squared change of the prediction is ĉ² plus a part of that
    cost, and the rise must be twice the root of this sum (:func:`held_out.holds_out`). The scatter
    of that cost between folds is neglected.
    """
    variance = FOLDS_SHARE * rank
    # The root solves (ĉ² − rank − variance)/2 = 2·√(ĉ² − rank + variance).
    root = STANDARD_ERRORS + np.sqrt(STANDARD_ERRORS**2 + 2.0 * variance)
    return _powerful(rank, np.inf, float(root**2 + rank - variance)) / max(shown, 1e-12)


def _size(
    effect: Effect, nonlinear: Nonlinear, sizes: Float, column: int, residuals: Residuals
) -> Parameter | None:
    """Return the first parameter of the effect that doubles when the coefficients double."""
    coefficients = np.zeros(sizes.size)
    coefficients[column] = sizes[column]
    covariance = np.zeros((sizes.size, sizes.size))
    once, twice = (
        effect.parameters(factor * coefficients, covariance, nonlinear, residuals.observations)
        for factor in (1.0, 2.0)
    )
    for name, item in once.items():
        value = abs(item.value)
        if value > 0.0 and abs(abs(twice[name].value) / value - 2.0) < PROPORTIONAL:
            return Parameter(value, 0.0, item.unit)
    return None


def _columns(
    effect: Effect, nonlinear: Nonlinear, solution: Solution
) -> list[tuple[str, NDArray[np.float64]]]:
    """Return the columns of an effect for a sample of the capture's rows, and for the reference's
    rows with the mean subtracted (a₀)."""
    observations, context = solution.observations, solution.context
    found = []
    if observations.capture is not None:
        rows = observations.capture
        thin = rows.part(slice(None, None, max(rows.run.size // MOST_ROWS, 1)))
        columns = capture_block(effect, thin, nonlinear, context)
        if columns is not None:
            found.append(("capture", columns))
    if observations.reference is not None:
        columns = effect.reference_columns(observations.reference, nonlinear, context)
        if columns is not None:
            found.append(("reference", columns - columns.mean(axis=0)))
    return found
