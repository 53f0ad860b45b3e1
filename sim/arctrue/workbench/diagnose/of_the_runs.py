"""What is known from run to run only, beside an index as good as it is known beforehand."""

from __future__ import annotations

from scipy.special import chdtrc, fdtrc

from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.effects.product_of_parts import ProductOfParts, recorded_conditions
from arctrue.workbench.inference.likelihood_ratio import with_index_as_known
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE, corrected_p_value

LEAST_OFFSETS = 2
"""Offsets of runs, beyond the columns of the effect, that must agree with the known index. A single
one agrees whenever two runs were moved alike, as by a head that was knocked in both."""


def leaves_the_index(known: Residuals, effect: Effect, nonlinear: Nonlinear) -> bool:
    """With the effect in the model, the offsets of the runs scatter as the index is known to.

    Else the index itself is worse than that, and one offset of few fits any effect.
    """
    score = known.score(effect, nonlinear)
    offsets = known.solution_with(effect, nonlinear, score).run_offsets_arcsec
    free = offsets.size - score.rank
    square = float(offsets @ offsets) / known.solution.noise.index_variance
    return free >= LEAST_OFFSETS and float(chdtrc(free, square)) >= SIGNIFICANCE


def p_among_the_runs(residuals: Residuals, effect: Effect, nonlinear: Nonlinear) -> float:
    """p of an effect whose sample is the runs, where the index is worse than it is known to be; 0
    where the index is as good as that, or too few offsets remain to tell.

    The F test of the offsets of the runs with and without the effect: what was known beforehand of
    the index does not count, since the offsets that remain with the effect contradict it.
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


def runs_differ_with(residuals: Residuals) -> str | None:
    """The condition with which the offsets of the runs go, beside a model; None where none is sure.

    p below SIGNIFICANCE over all conditions, of an index variance that is known from as many runs
    as the knowledge beforehand is worth.
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
            best = score.gain, condition.part.partition("^")[0]
    return None if best is None else best[1]
