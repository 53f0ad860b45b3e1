"""Candidates that this data cannot tell from the best one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.significance import corrected_p_value
from arctrue.workbench.inference.residuals import Residuals

LEAST_SHARE = 0.5
"""A candidate that takes less than this share of the best one's gain cannot stand in for it."""
NOTHING_LEFT_P = 0.001
"""Beside the other, an effect adds nothing when its gain, for all places that it looked at, is no
rarer than this."""


@dataclass
class Similar:
    """Names of candidates like the best: those of equal freedom, and larger ones around it."""

    equals: list[str] = field(default_factory=list)
    larger: list[str] = field(default_factory=list)

    @property
    def all_names(self) -> list[str]:
        """Both lists."""
        return [*self.equals, *self.larger]


def alike(best: Candidate, others: Sequence[Candidate]) -> Similar:
    """Candidates whose columns explain what the best one explains."""
    similar = Similar()
    for other in others:
        if other.gain < LEAST_SHARE * best.gain or other.name == best.name:
            continue
        if other.effect.unspecific and not best.effect.unspecific:
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


def stands_in(best: Candidate, other: Candidate) -> bool:
    """With the other in the model, the best one adds nothing more than its own search may find."""
    return not adds(best, other)


def without_unspecific(found: Sequence[Candidate]) -> list[Candidate]:
    """Without effects that only say what is seen, where one that says why takes as much."""
    specific = [item for item in found if not item.effect.unspecific]
    return [
        item
        for item in found
        if not item.effect.unspecific or not any(stands_in(item, other) for other in specific)
    ]
