"""Finds other conditions with which a product of parts describes the error equally well.

If a load rises from run to run, the error may grow with the load or with the time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.confounded import EQUAL_COLUMNS
from arctrue.workbench.diagnose.next_measurement import NextMeasurement
from arctrue.workbench.effects.part_conditions import (
    ALWAYS,
    CONDITIONS,
    Condition,
    conditions_by_direction,
    recorded_conditions,
)
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.canonical_correlation import canonical_correlations
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.residuals import Residuals


def equal_description(
    described: Candidate, residuals: Residuals, near_tie: float
) -> Candidate | None:
    """Return the product with another condition that describes the same error as well; the most
    probable, if there are several, and None if the rows separate the conditions.

    The zero of every condition is fitted: the error of a load is zero at 0 N·m, the error of a
    drift at the start, and only this constant would distinguish the two. Twice the log likelihoods
    may then differ by at most ``near_tie``, and the columns must be alike.
    """
    effect = described.effect
    if not isinstance(effect, ProductOfParts) or not effect.condition.part or effect.turned_by:
        return None
    base = residuals if described.evidence is None else described.evidence.base
    condition = effect.condition
    zero = _with(effect, CONDITIONS["direction"] if condition.by_direction else ALWAYS)
    score = base.score(zero, {})
    free = Residuals(base.solution_with(zero, {}, score)) if score.rank else base
    own = free.score(effect, described.nonlinear)
    found: list[tuple[float, Candidate]] = []
    observations = residuals.observations
    for other in _others(condition, residuals):
        form = _with(effect, other)
        if form.missing(observations):
            continue
        there = free.score(form, {})
        if there.rank != own.rank or there.rank == 0 or there.gain < own.gain - near_tie:
            continue
        correlations = canonical_correlations(free, described.term, Term(form, {}))
        if correlations.size < own.rank or float(np.min(correlations)) < EQUAL_COLUMNS:
            continue
        solution = free.solution_with(form, {}, there)
        found.append((there.gain, replace(described, effect=form, nonlinear={}, solution=solution)))
    return max(found, key=lambda item: item[0], default=(0.0, None))[1]


def _with(effect: ProductOfParts, condition: Condition) -> ProductOfParts:
    """Return the product with another condition."""
    return ProductOfParts.of(condition, effect.orders, effect.frame, effect.electrical_head)


def _others(condition: Condition, residuals: Residuals) -> list[Condition]:
    """Return the conditions of the same kind, with the direction as a factor or without it."""
    observations = residuals.observations
    if condition.by_direction:
        found = [CONDITIONS["direction*time"], *conditions_by_direction(observations)]
    else:
        found = recorded_conditions(observations)
    return [item for item in found if item.part != condition.part]


def to_separate(described: Candidate, other: Candidate) -> NextMeasurement:
    """Return the measurement that separates the conditions of two equal descriptions."""
    first, second = (_part(item) for item in (described, other))
    if second == "time":
        first, second = second, first
    if first in ("time", "settling"):
        how = f"the same runs once more with {second} in another order, for example falling"
    else:
        how = f"the same runs once more with {second} held while {first} changes, or the reverse"
    return NextMeasurement(f"{how}: in this set it changed together with the {first}", None)


def _part(item: Candidate) -> str:
    assert isinstance(item.effect, ProductOfParts)
    return item.effect.condition.without_power
