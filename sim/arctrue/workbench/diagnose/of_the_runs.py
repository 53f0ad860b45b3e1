"""Tests effects that appear only in the differences between runs.

The tests compare the offsets of the runs with the index repeatability that was known before the
set.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, fdtrc

from arctrue.workbench.effects.base import Effect, Nonlinear, Parameter
from arctrue.workbench.effects.part_conditions import recorded_conditions
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.likelihood_ratio import (
    with_index_as_known,
    without_slow_noise,
)
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE, corrected_p_value
from arctrue.workbench.numeric.distributions import student_upper_p

LEAST_OFFSETS = 2
"""Smallest number of free offsets (runs minus columns of the effect) for the comparison with the
known index repeatability. With one free offset, an effect may fit all offsets because two runs have
the same shift, for example if a head was displaced before both runs."""

LEAST_RUNS = 6
"""Smallest number of runs whose offsets are compared with a condition. With five runs only a
correlation above 0.999 would be significant."""
LEAST_SCATTER = 4
"""Smallest number of runs whose scatter is compared with the known index: three free offsets."""
LEAST_OF_A_DIRECTION = 2
"""Smallest number of runs of each direction whose offsets are compared: a single run may differ
from the others by a shift between two runs."""
DIFFERENCE_P = 0.0027
"""Largest p of a stated difference of the directions: that of three standard uncertainties with a
known index."""
FOLLOWS_P = 1e-4
"""Largest p, over all conditions, at which the offsets count as a function of a condition; it
equals the limit of a sure lack of fit."""


@dataclass(frozen=True)
class FollowedCondition:
    """Condition that the offsets of the runs follow, and the RMS of the offsets in arcseconds."""

    part: str
    rms_arcsec: float
    index_arcsec: float
    """Known standard deviation of the index, arcseconds."""


def leaves_the_index(known: Residuals, effect: Effect, nonlinear: Nonlinear) -> bool:
    """Tell whether the runs' offsets, with the effect in the model, have the known index scatter.

    If the offsets scatter more, the index repeats worse than known, and an effect can then fit one
    of a few offsets by chance.
    """
    score = known.score(effect, nonlinear)
    offsets = known.solution_with(effect, nonlinear, score).run_offsets_arcsec
    free = offsets.size - score.rank
    square = float(offsets @ offsets) / known.solution.noise.index_variance
    return free >= LEAST_OFFSETS and float(chdtrc(free, square)) >= SIGNIFICANCE


def p_among_the_runs(residuals: Residuals, effect: Effect, nonlinear: Nonlinear) -> float:
    """Return p of an effect whose sample is the runs, if the index repeats worse than its known
    repeatability.

    The result is 0 if the index repeats as well as known, or if too few offsets remain to decide.
    The F test compares the squares of the runs' offsets without and with the effect. The prior
    knowledge of the index does not count, since the offsets that remain with the effect contradict
    it.
    """
    known = with_index_as_known(residuals)
    score = known.score(effect, nonlinear)
    before = known.solution.run_offsets_arcsec
    after = known.solution_with(effect, nonlinear, score).run_offsets_arcsec
    free = after.size - score.rank
    left = float(after @ after)
    if score.rank == 0 or free < LEAST_OFFSETS or left <= 0.0:
        return 0.0
    if float(chdtrc(free, left / known.solution.noise.index_variance)) >= SIGNIFICANCE:
        return 0.0
    taken = max(float(before @ before) - left, 0.0)
    return float(fdtrc(score.rank, free, taken / score.rank * free / left))


def offsets_are_large(left: Residuals, before: Residuals, share: float) -> bool:
    """Tell whether the offsets of the runs that an effect leaves may belong to the effect's shape.

    Their mean square is then more than ``share`` of the mean square that the effect removes.
    Smaller offsets are an error of their own, for example an index that repeats worse than known.
    """
    after, without = (
        with_index_as_known(item).solution.run_offsets_arcsec for item in (left, before)
    )
    remaining = float(after @ after)
    return remaining > share * max(float(without @ without) - remaining, 0.0)


@dataclass(frozen=True)
class IndexScatter:
    """Scatter of the runs' offsets beyond the known repeatability of the index."""

    rms_arcsec: float
    index_arcsec: float
    """Known standard deviation of the index, arcseconds."""

    def sentence(self) -> str:
        """Return the scatter as a sentence."""
        return (
            f"The offsets of the runs scatter by {self.rms_arcsec:.2g}″, but the known "
            f"repeatability of the index is {self.index_arcsec:.2g}″: the index is worse, or "
            "something moves the heads between the runs."
        )


def index_beyond_its_prior(residuals: Residuals) -> IndexScatter | None:
    """Return the scatter of the runs' offsets if the known repeatability of the index cannot cause
    it (F test, p below FOLLOWS_P); otherwise None.

    The fit estimates the variance of the index from these offsets, which therefore never contradict
    the model. The known repeatability has the degrees of freedom of its prior, in runs.
    """
    if residuals.observations.capture is None or residuals.observations.runs < (
        LEAST_SCATTER * residuals.observations.capture.channels
    ):
        return None
    offsets = residuals.solution.run_offsets_arcsec
    channels = residuals.observations.capture.channels
    about_mean = np.concatenate(
        [offsets[one::channels] - offsets[one::channels].mean() for one in range(channels)]
    )
    free = about_mean.size - channels
    known = residuals.observations.index_sigma_arcsec
    ratio = float(about_mean @ about_mean) / free / max(known, 1e-300) ** 2
    if float(fdtrc(free, residuals.solution.noise.index_freedom, ratio)) >= FOLLOWS_P:
        return None
    return IndexScatter(float(np.sqrt(np.sum(about_mean**2) / free)), known)


@dataclass(frozen=True)
class DirectionDifference:
    """Difference of the mean offsets of the runs in the two directions, and its standard
    uncertainty from the known index or, if it is larger, from the scatter of the runs;
    arcseconds."""

    size_arcsec: float
    u_arcsec: float

    def sentence(self) -> str:
        """Return the difference as a sentence."""
        return (
            f"The runs in the two directions differ by {self.size_arcsec:.3g}″ in R₂ − R₁ "
            f"(u {self.u_arcsec:.2g}″, from run to run); this is not enough to name an effect of "
            "the direction or of the speed."
        )


def direction_difference(residuals: Residuals) -> DirectionDifference | None:
    """Return the difference of R₂ − R₁ between the directions if its p is at most DIFFERENCE_P;
    None otherwise, and if a direction has fewer than LEAST_OF_A_DIRECTION runs."""
    observations = residuals.observations
    rows = observations.capture
    if rows is None or rows.channels != 1:
        return None
    known = with_index_as_known(residuals).solution.run_offsets_arcsec
    way = np.sign(rows.direction[np.unique(rows.run, return_index=True)[1]])
    up, down = known[way > 0.0], known[way < 0.0]
    if min(up.size, down.size) < LEAST_OF_A_DIRECTION:
        return None
    within = float(np.sum((up - up.mean()) ** 2) + np.sum((down - down.mean()) ** 2))
    scatter = float(np.sqrt(within / (known.size - 2)))
    sigma = max(observations.index_sigma_arcsec, scatter)
    size = abs(float(up.mean() - down.mean()))
    u_arcsec = sigma * float(np.sqrt(1.0 / up.size + 1.0 / down.size))
    # A scatter above that of the index is known from the offsets alone, with n − 2 degrees of
    # freedom.
    freedom = known.size - 2.0 if scatter > observations.index_sigma_arcsec else np.inf
    if 2.0 * student_upper_p(size / u_arcsec, freedom) > DIFFERENCE_P:
        return None
    return DirectionDifference(size, u_arcsec)


def head_1_reverses(left: Residuals, reversal: Parameter) -> str | None:
    """Explain in words why head 1 alone causes a reversal error of the reference; None if the disc
    may cause it.

    ``left``: residuals with the reversal error in the model. Friction between disc and table does
    not change R₂ − R₁. If head 1 alone moves with the direction, R₂ − R₁ changes by the reversal
    error with the opposite sign. The change must be significant (p below DIFFERENCE_P) and may
    differ from this value by chance only. Its uncertainty follows from the scatter of the runs
    within each direction and from the known index, which has the degrees of freedom of its prior.
    The fit of the offsets has only white noise, because slow noise that was estimated without the
    change would absorb it.
    """
    observations, index = left.observations, left.solution.noise
    rows = observations.capture
    if rows is None or rows.channels != 1 or rows.runs - 2 < 1:
        return None
    offsets = with_index_as_known(without_slow_noise(left)).solution.run_offsets_arcsec
    way = np.sign(rows.direction[np.unique(rows.run, return_index=True)[1]])
    up, down = offsets[way > 0.0], offsets[way < 0.0]
    if min(up.size, down.size) < 1:
        return None
    within = float(np.sum((up - up.mean()) ** 2) + np.sum((down - down.mean()) ** 2))
    freedom = index.index_freedom + up.size + down.size - 2.0
    variance = (index.index_freedom * observations.index_sigma_arcsec**2 + within) / freedom
    u_arcsec = float(np.sqrt(variance * (1.0 / up.size + 1.0 / down.size)))
    size = float(up.mean() - down.mean())
    away = abs(size + reversal.value) / float(np.hypot(u_arcsec, reversal.sigma))
    if (
        2.0 * student_upper_p(abs(size) / u_arcsec, freedom) >= DIFFERENCE_P
        or 2.0 * student_upper_p(away, freedom) < SIGNIFICANCE
    ):
        return None
    return (
        f"R₂ − R₁ also differs between the directions, by {size:.3g}″ (u {u_arcsec:.2g}″), the "
        "reversal error with the opposite sign: head 1 alone moves with the direction, and not the "
        "disc"
    )


def offsets_follow(residuals: Residuals) -> FollowedCondition | None:
    """Return the condition that the offsets of the runs follow as a linear or quadratic function;
    None if they follow no condition, or are within the known scatter of the index.

    The constant of the function is free. The sample of the F test is the runs, not the rows: noise
    or lag of a thermometer within a run can hide a dependence that the means of the runs show.
    """
    observations = residuals.observations
    rows = observations.capture
    channels = 1 if rows is None else rows.channels
    if rows is None or observations.runs < LEAST_RUNS * channels:
        return None
    known = with_index_as_known(residuals).solution
    offsets, variance = known.run_offsets_arcsec, known.noise.index_variance
    size = np.bincount(rows.run, minlength=offsets.size)
    conditions = [
        (item.without_power, np.bincount(rows.run, values, offsets.size) / size)
        for item in recorded_conditions(observations)
        if (values := item.values(rows)) is not None
    ]
    found: list[tuple[float, FollowedCondition]] = []
    for channel in range(channels):
        own = offsets[channel::channels]
        about_mean = own - own.mean()
        if float(chdtrc(own.size - 1, float(about_mean @ about_mean) / variance)) > FOLLOWS_P:
            continue
        rms, index = float(np.sqrt(np.mean(about_mean**2))), float(np.sqrt(variance))
        for part, means in conditions:
            for degree in (1, 2):
                p_value = _p_of_a_curve(means[channel::channels], about_mean, degree)
                found.append((p_value, FollowedCondition(part, rms, index)))
    p_value, best = min(found, key=lambda item: item[0], default=(1.0, None))
    return best if p_value * max(len(found), 1) < FOLLOWS_P else None


def _p_of_a_curve(
    condition: NDArray[np.float64], offsets: NDArray[np.float64], degree: int
) -> float:
    """Return p of the F test of a polynomial through offsets whose mean is 0; 1 if the condition
    has too few different values to test it."""
    away = condition - condition.mean()
    largest = float(np.abs(away).max())
    square = float(offsets @ offsets)
    different = np.unique(np.round(away / max(largest, 1e-300), 3)).size
    free = offsets.size - degree - 1
    if square <= 0.0 or largest <= 0.0 or different < degree + 2 - (degree == 1):
        return 1.0
    columns = np.vander(away / largest, degree + 1)
    left = offsets - columns @ np.linalg.lstsq(columns, offsets, rcond=1e-10)[0]
    share = max(1.0 - float(left @ left) / square, 0.0)
    return float(fdtrc(degree, free, free * share / degree / max(1.0 - share, 1e-300)))


def runs_differ_with(residuals: Residuals) -> str | None:
    """Return the condition on which the offsets of a model's runs depend; None if none is
    significant.

    p must be below SIGNIFICANCE over all conditions; the index variance has the degrees of freedom
    of its prior knowledge.
    """
    if residuals.observations.runs == 0:
        return None
    known = with_index_as_known(residuals)
    found = recorded_conditions(residuals.observations)
    best: tuple[float, str] | None = None
    for condition in found:
        form = ProductOfParts.of(condition, (), "head2")
        if form.missing(residuals.observations):
            continue
        score = known.score(form, {})
        p_value = corrected_p_value(
            score.gain, score.rank, 1.0, len(found), known.solution.noise.index_freedom
        )
        if (
            score.rank
            and p_value < SIGNIFICANCE
            and leaves_the_index(known, form, {})
            and (best is None or score.gain > best[0])
        ):
            best = score.gain, condition.without_power
    return None if best is None else best[1]
