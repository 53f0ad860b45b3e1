"""Candidates that this data cannot tell from the best one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from scipy.stats import chi2

from arctrue.diagnose.candidate import Candidate
from arctrue.effects.base import Effect
from arctrue.fit.residuals import Residuals

LEAST_SHARE = 0.5
"""A candidate that takes less than this share of the best one's gain cannot stand in for it."""
NOTHING_LEFT_P = 0.001
"""Beside the other, the best one adds nothing when its gain is no rarer than this."""


@dataclass
class Similar:
    """Names of candidates like the best: those of equal freedom, and larger ones around it."""

    equals: list[str] = field(default_factory=list)
    larger: list[str] = field(default_factory=list)

    @property
    def all_names(self) -> list[str]:
        """Both lists."""
        return [*self.equals, *self.larger]


def alike(
    best: Candidate,
    others: Sequence[Candidate],
    residuals: Residuals,
    effects: Mapping[str, type[Effect]],
) -> Similar:
    """Candidates whose columns explain what the best one explains."""
    similar = Similar()
    for other in others:
        if other.gain < LEAST_SHARE * best.gain or other.name == best.name:
            continue
        if not _stands_in(best, other):
            continue
        if other.rank > best.rank:
            similar.larger.append(other.name)
        else:
            similar.equals.append(other.name)
    return similar


def _stands_in(best: Candidate, other: Candidate) -> bool:
    """With the other in the model, the best one adds nothing more."""
    left = Residuals(other.solution).score(best.effect, best.nonlinear)
    if left.rank == 0:
        return True
    return left.gain < float(chi2.isf(NOTHING_LEFT_P, left.rank))
