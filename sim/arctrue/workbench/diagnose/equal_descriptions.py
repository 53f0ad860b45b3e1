"""Finds other conditions with which a product of parts describes the error equally well.

If a load rises from run to run, the error may grow with the load or with the time.
"""

from __future__ import annotations

from collections.abc import Sequence
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


def equal_descriptions(
    described: Candidate, residuals: Residuals, near_tie: float
) -> list[Candidate]:
    """Return the products with another condition that describe the same error as well, the most
    probable first; an empty list if the rows separate the conditions.

    The zero of every condition is fitted: the error of a load is zero at 0 N·m, the error of a
    drift at the start, and only this constant would distinguish the two. Twice the log likelihoods
    may then differ by at most ``near_tie``, and the columns must be alike.
    """
    effect = described.effect
    if not isinstance(effect, ProductOfParts) or not effect.condition.part or effect.turned_by:
        return []
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
    return [item for _, item in sorted(found, key=lambda item: -item[0])]


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


def to_separate(described: Candidate, equals: Sequence[Candidate]) -> NextMeasurement:
    """Return the measurement that separates the conditions of equal descriptions."""
    parts = _parts([described, *equals])
    first, *others = parts
    if not others:
        # Two functions of one quantity, such as speed² and |speed|, are the same at two values.
        forms = " and ".join(_words(item) for item in (described, *equals))
        return NextMeasurement(
            f"the same run once more at a value of the {first} that this set does not have: at its "
            f"values, {forms} describe the error equally well",
            None,
        )
    together = "it" if len(others) == 1 else "they"
    second = _listed(others)
    if first in ("time", "settling"):
        how = f"the same runs once more with {second} in another order, for example falling"
        if len(others) > 1:
            how = f"the same runs once more with {second} in other orders, each in its own"
    elif len(others) == 1:
        how = f"the same runs once more with {second} held while {first} changes, or the reverse"
    else:
        how = f"the same runs once more, in which only one of {_listed(parts)} changes at a time"
    return NextMeasurement(f"{how}: in this set {together} changed together with the {first}", None)


def also_to_separate(
    measurement: NextMeasurement | None, described: Candidate, equals: Sequence[Candidate]
) -> NextMeasurement | None:
    """Return the measurement for the first effect of a class and ``described``, with what separates
    ``described`` from its equals."""
    first, *others = [part for part in _parts([described, *equals]) if part != "time"] or [""]
    if not others:
        return measurement
    if measurement is None:
        return to_separate(described, equals)
    order = "another order" if len(others) == 1 else "other orders"
    words = (
        f"{measurement.words}; with {_listed(others)} in {order}, it also separates "
        f"{_listed(others)} from {first}"
    )
    return replace(measurement, words=words)


def _parts(found: Sequence[Candidate]) -> list[str]:
    """Return the conditions of descriptions, each once: the time first, then the temperature, which
    cannot follow any order."""
    parts = dict.fromkeys(_part(item) for item in found)
    return sorted(parts, key=lambda part: (part != "time", part != "temperature"))


def _listed(parts: Sequence[str]) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def _words(item: Candidate) -> str:
    assert isinstance(item.effect, ProductOfParts)
    return item.effect.condition.words


def _part(item: Candidate) -> str:
    assert isinstance(item.effect, ProductOfParts)
    return item.effect.condition.without_power
