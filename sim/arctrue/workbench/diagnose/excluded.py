"""Finds effects that a set cannot test and that would look like the effect that fits best."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.classes import LEAST_SHARE
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.canonical_correlation import canonical_correlations
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.residuals import Residuals

LIKE = 0.95
"""Smallest canonical correlation that every direction of the best effect must have with the other
effect's columns."""


def look_alikes(
    best: Candidate,
    residuals: Residuals,
    untestable: Mapping[str, list[str]],
    effects: Mapping[str, type[Effect]],
) -> dict[str, list[str]]:
    """Return effects (without search parameters) that would look like ``best``, each with the data
    that the set lacks to test it.

    The columns of such an effect, with the model projected out, reproduce those of ``best`` on the
    rows of the set: each canonical correlation is above LIKE. The gain of such an effect is at
    least LEAST_SHARE of the gain of ``best``.
    """
    found = {}
    for name, lacking in untestable.items():
        effect = effects[name]()
        if effect.search or not _has_columns(effect, residuals):
            continue
        there = best.evidence.base if best.evidence is not None else residuals
        score = there.score(effect, {})
        if score.rank < best.rank or score.gain < LEAST_SHARE * best.gain:
            continue
        alike = canonical_correlations(there, best.term, Term(effect, {}))
        if alike.size >= best.rank and float(np.min(alike[: best.rank])) > LIKE:
            found[name] = lacking
    return found


def _has_columns(effect: Effect, residuals: Residuals) -> bool:
    """Tell whether the columns of the effect can be calculated on these rows.

    An effect, possibly a user's own, may raise any exception if a column that it needs is missing.
    """
    try:
        columns = residuals.whitened_columns(effect, {})
    except (TypeError, AttributeError, AssertionError, KeyError, ValueError, IndexError):
        return False
    return any(item is not None and np.all(np.isfinite(item)) for item in columns)
