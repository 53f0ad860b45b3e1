"""Finds effects that a set cannot test and that would look like the effect that fits best."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from arctrue.workbench.diagnose.adding import has_columns
from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.classes import LEAST_SHARE, family_gain
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.canonical_correlation import canonical_correlations
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.residuals import Residuals

LIKE = 0.95
"""Smallest canonical correlation that every direction of the best effect must have with the other
effect's columns."""
MOST_COUNTS_A_PERIOD = 2**16
"""Largest number of counts in a signal period; encoders for tables of 2²⁹ counts have up to 2¹⁵
lines (HEIDENHAIN RCN 8000), 2¹⁴ counts each."""


def look_alikes(
    best: Candidate,
    residuals: Residuals,
    untestable: Mapping[str, list[str]],
    effects: Mapping[str, type[Effect]],
    near_tie: float,
) -> dict[str, list[str]]:
    """Return effects (without search parameters) that would look like ``best``, each with the data
    that the set lacks to test it.

    The columns of such an effect, with the model projected out, reproduce those of ``best`` on the
    rows of the set: each canonical correlation is above LIKE. The gain of such an effect is at
    least LEAST_SHARE of the gain of ``best``. Without a stated number of grating lines, an effect
    of the signal is left out if twice the log evidence of ``best`` exceeds that of the effect by
    more than ``near_tie``.
    """
    found = {}
    for name, lacking in untestable.items():
        effect = effects[name]()
        there = best.evidence.base if best.evidence is not None else residuals
        if effect.of_the_signal and there.observations.grating_lines is None:
            found_here = _of_signal(best, effect, there)
            if found_here is None:
                continue
            effect, there = found_here
            own, other = there.score(best.effect, best.nonlinear), there.score(effect, {})
            ahead = family_gain(own) - 2.0 * float(np.log(max(best.trials, 1.0)))
            if ahead - family_gain(other) > near_tie:
                continue
        if effect.search or not has_columns(effect, there):
            continue
        score = there.score(effect, {})
        if score.rank < best.rank or score.gain < LEAST_SHARE * best.gain:
            continue
        correlations = canonical_correlations(there, best.term, Term(effect, {}))
        if correlations.size >= best.rank and float(np.min(correlations[: best.rank])) > LIKE:
            found[name] = lacking
    return found


def _of_signal(
    best: Candidate, effect: Effect, residuals: Residuals
) -> tuple[Effect, Residuals] | None:
    """Return the effect of the signal that has the order of ``best``, an order of the disc, and the
    residuals with the signal phases; None if no grating makes this order a multiple of its signal
    period.

    An interpolator divides a signal period into a whole number of counts.
    """
    observations = residuals.observations
    rows, reference = observations.capture, observations.reference
    counts = observations.counts_per_rev
    if rows is None or counts is None or best.effect.search_kind != "disc_order":
        return None
    order = round(best.nonlinear["order"])
    for times in effect.integers("multiples") if "multiples" in effect.defaults else []:
        lines = order // times
        if lines * times != order or counts % lines or counts > MOST_COUNTS_A_PERIOD * lines:
            continue
        further = rows.further_line_rad
        rows = replace(
            rows,
            electrical1_rad=rows.line1_rad * lines,
            electrical2_rad=rows.line2_rad * lines,
            further_electrical_rad=None if further is None else further * lines,
        )
        if reference is not None:
            reference = replace(reference, electrical1_rad=reference.line_rad * lines)
        signal = replace(observations, capture=rows, reference=reference, grating_lines=lines)
        return (
            type(effect)(multiples=[times]),
            Residuals(replace(residuals.solution, observations=signal)),
        )
    return None
