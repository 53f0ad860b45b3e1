"""Tests effects that appear only in the differences between runs.

The tests compare the offsets of the runs with the index repeatability that was known before the
set.
"""

from __future__ import annotations

from scipy.special import chdtrc, fdtrc

from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.effects.product_of_parts import ProductOfParts, recorded_conditions
from arctrue.workbench.inference.likelihood_ratio import with_index_as_known
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE, corrected_p_value

LEAST_OFFSETS = 2
"""Smallest number of free offsets (runs minus columns of the effect) for the comparison with the
known index repeatability. A single free offset agrees whenever two runs have the same shift, for
example if a head was displaced before both runs."""


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
            best = score.gain, condition.part.partition("^")[0]
    return None if best is None else best[1]
