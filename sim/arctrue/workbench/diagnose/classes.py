"""Candidates that this data cannot tell from the best one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import minimize_scalar

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.inference.residuals import Residuals, Score
from arctrue.workbench.inference.scan import TOLD_APART
from arctrue.workbench.inference.significance import corrected_p_value
from arctrue.workbench.numeric.symmetric import RANK_TOLERANCE

LEAST_SHARE = 0.5
"""A candidate that takes less than this share of the best one's gain cannot stand in for it."""
NOTHING_LEFT_P = 0.001
"""Beside the other, an effect adds nothing when its gain, for all places that it looked at, is no
rarer than this."""
OF_THE_SAME_KIND = 0.1
"""Share of the first effect's gain and of its mean square: what is left beside it and is larger, a
third of its size, may be its own shape, that the catalogue does not have. Smaller, it is a matter
of its own."""
FAR = 30.0
"""Of the logarithm of a variance, to either side of that at which noise and effect are alike."""


@dataclass
class Similar:
    """Names of candidates like the best: those of equal freedom, and larger ones around it."""

    equals: list[str] = field(default_factory=list)
    larger: list[str] = field(default_factory=list)

    @property
    def all_names(self) -> list[str]:
        """Both lists."""
        return [*self.equals, *self.larger]


def alike(best: Candidate, others: Sequence[Candidate], *, unspecific: bool = False) -> Similar:
    """Candidates whose columns explain what the best one explains.

    ``unspecific``: those count too that only say what is seen, where the best says why.
    """
    similar = Similar()
    for other in others:
        if other.gain < LEAST_SHARE * best.gain or other.name == best.name:
            continue
        if other.effect.unspecific and not (unspecific or best.effect.unspecific):
            continue
        if not stands_in(best, other):
            continue
        if other.rank > best.rank:
            similar.larger.append(other.name)
        else:
            similar.equals.append(other.name)
    return similar


def adds(item: Candidate, other: Candidate) -> bool:
    """With the other in the model, the first still takes more than chance gives at its place.

    Both with the same noise: that beside the first, or beside the other where the first was not
    weighed with a noise of its own.
    """
    known = item.evidence or other.evidence
    solution, share = other.solution, 1.0
    if known is not None:
        score = known.base.score(other.effect, other.nonlinear)
        solution = known.base.solution_with(other.effect, other.nonlinear, score)
        alone = known.base.score(item.effect, item.nonlinear).gain
        # On the scale of the likelihoods with the noise free on both sides.
        share = item.gain / max(alone, 1e-300)
    left = Residuals(solution).score(item.effect, item.nonlinear)
    freedom = min(item.freedom, other.freedom)
    p_value = corrected_p_value(left.gain * share, left.rank, item.trials, 1, freedom)
    return p_value < NOTHING_LEFT_P


def lead(item: Candidate, other: Candidate) -> float:
    """By how much the first is ahead of the other, as twice the log of their evidences' ratio.

    Both with the same noise, and each a family of coefficients of one size (:func:`family_gain`):
    a BIC would charge the 23 faces of a polygon as if each had a size of its own.
    """
    known = item.evidence or other.evidence
    if known is None:
        return item.delta_bic - other.delta_bic
    worth = []
    for one in (item, other):
        score = known.base.score(one.effect, one.nonlinear)
        worth.append(family_gain(score) - 2.0 * float(np.log(max(one.trials, 1.0))))
    return worth[0] - worth[1]


def family_gain(score: Score) -> float:
    """Twice the log of the largest evidence with coefficients b ~ N(0, s²·1), s free.

    In the directions of the information, of eigenvalues λ, with z² the gain along each:
    Σ s²λ·z²/(1 + s²λ) − log(1 + s²λ) (random effects; Harville, J. Am. Stat. Assoc. 72 (1977)
    320).
    """
    values, vectors = np.linalg.eigh(score.information)
    told = values > RANK_TOLERANCE * max(float(values.max(initial=0.0)), 1e-300)
    if not told.any():
        return 0.0
    values = values[told]
    gains = (vectors[:, told].T @ score.moment) ** 2 / values

    def loss(log_square: float) -> float:
        ratio = np.exp(log_square) * values
        return -float(np.sum(gains * ratio / (1.0 + ratio) - np.log1p(ratio)))

    middle = -float(np.log(np.median(values)))
    best = minimize_scalar(loss, bounds=(middle - FAR, middle + FAR), method="bounded")
    return max(0.0, -float(best.fun))


def stands_in(best: Candidate, other: Candidate) -> bool:
    """With the other in the model, the best one adds nothing more than its own search may find."""
    return not adds(best, other)


def without_unspecific(found: Sequence[Candidate]) -> list[Candidate]:
    """Without effects that only say what is seen, where one that says why takes as much."""
    specific = [item for item in found if not item.effect.unspecific]
    return [
        item
        for item in found
        if not item.effect.unspecific or not any(_explained(item, other) for other in specific)
    ]


def _explained(line: Candidate, other: Candidate) -> bool:
    return stands_in(line, other) or of_its_order(line, other)


def of_its_order(line: Candidate, other: Candidate) -> bool:
    """The line is at the order of the disc that the other effect searched, which takes most of it.

    A line has a size and a phase for each head, so that it also takes what moves an order of the
    disc by a little: an eccentric disc of 80″ moves the phase of order 120 by 0.05. At the whole
    order the line must take as much as at its own, or the orders differ.
    """
    if other.effect.search_kind != "disc_order" or line.nonlinear.get("in_time"):
        return False
    known = line.evidence or other.evidence
    order, whole = line.nonlinear.get("order", 0.0), other.nonlinear["order"]
    if known is None or abs(order - whole) > known.base.observations.order_resolution:
        return False
    base = known.base
    own = base.score(line.effect, line.nonlinear).gain
    there = {**line.nonlinear, "order": whole}
    if own - base.score(line.effect, there).gain > TOLD_APART:
        return False
    score = base.score(other.effect, other.nonlinear)
    beside = Residuals(base.solution_with(other.effect, other.nonlinear, score))
    return beside.score(line.effect, there).gain < OF_THE_SAME_KIND * own
