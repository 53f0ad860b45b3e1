"""Finds conditions that changed together, so that an error may depend on one or on the other.

A run that warms evenly cannot distinguish the influence of temperature from the influence of time,
even if a drift is certain.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate, delta_bic
from arctrue.workbench.effects.base import orders_of_parts
from arctrue.workbench.effects.part_conditions import ALWAYS, recorded_conditions
from arctrue.workbench.effects.product_of_parts import FRAME_OF_HEAD, Frame, ProductOfParts
from arctrue.workbench.inference.canonical_correlation import canonical_correlations
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.residuals import Residuals

EQUAL_COLUMNS = 0.98
"""Columns count as equal if their canonical correlation, with the model projected out, is at least
this value. With one effect in the model, 4 % of the gain of the other effect remains at this
correlation; these 4 % exceed a near tie of 6 only for a gain above 150."""
FRAMES: tuple[Frame, ...] = ("disc", "stator", *FRAME_OF_HEAD.values(), "reference")


def confounded_with(best: Candidate, near_tie: float) -> Candidate | None:
    """Return ``best`` with another condition of the set, if the rows cannot distinguish the two. If
    several conditions qualify, return the most probable.

    The result is None where ``best`` does not state its parts, or where the rows distinguish the
    conditions: twice the log likelihood of ``best`` is larger by more than ``near_tie``.
    """
    evidence, parts = best.evidence, best.effect.in_parts
    frame = next((name for name in FRAMES if name in parts), None)
    if evidence is None or frame is None:
        return None
    orders = orders_of_parts(parts)
    base = evidence.base
    found: list[Candidate] = []
    free, of_constant = base, 0.0
    if not orders and frame in FRAME_OF_HEAD.values():
        # Two conditions have different zeros, so that their columns also differ by a constant. The
        # angle between the heads is known to the mounting tolerance only and may cause this
        # constant, which is therefore fitted.
        constant = ProductOfParts.of(ALWAYS, (), frame)
        found_there = base.score(constant, {})
        if found_there.rank:
            free = Residuals(base.solution_with(constant, {}, found_there))
            of_constant = found_there.gain
    for condition in recorded_conditions(base.observations):
        form = ProductOfParts.of(condition, orders, frame)
        if condition.part in parts or form.missing(base.observations):
            continue
        score = base.score(form, {})
        gained = max(score.gain, of_constant + free.score(form, {}).gain)
        if score.rank != evidence.score.rank or gained < evidence.score.gain - near_tie:
            continue
        correlations = canonical_correlations(free, best.term, Term(form, {}))
        if correlations.size < score.rank or float(np.min(correlations)) < EQUAL_COLUMNS:
            continue
        gain = best.gain * min(gained / max(evidence.score.gain, 1e-300), 1.0)
        found.append(
            replace(
                best,
                effect=form,
                nonlinear={},
                gain=gain,
                trials=1.0,
                solution=base.solution_with(form, {}, score),
                delta_bic=delta_bic(gain, score.rank, 1.0, best.rows),
                lacking_variety=[],
                level_trials=None,
                asked=None,
                evidence=replace(evidence, score=score),
            )
        )
    return max(found, key=lambda item: item.gain, default=None)
