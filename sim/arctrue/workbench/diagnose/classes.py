"""Finds the candidates that this data cannot distinguish from the best candidate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.waves import SEPARATING_GAIN
from arctrue.workbench.inference.score_test import Score
from arctrue.workbench.inference.significance import corrected_p_value
from arctrue.workbench.numeric.symmetric import RANK_TOLERANCE

LEAST_SHARE = 0.5
"""Least share of the best candidate's gain that another candidate needs to be in the class of the
best candidate."""
NOTHING_LEFT_P = 0.001
"""The gain of an effect that is added to a model with another effect counts as chance if the
corrected p of this gain is at least this value."""
OF_THE_SAME_KIND = 0.1
"""Limit of an unknown remaining error, as a share of the first effect's gain and of its mean
square. A larger error (more than a third of the effect's size) may show that the real effect has
another shape than the named effect; a smaller error counts as the error of a separate cause.
"""
FAR = 30.0
"""Half the width of the range in which log s² is searched, around the value where the effect is as
large as the noise."""


@dataclass(frozen=True)
class Similar:
    """Names of the candidates that this data cannot distinguish from the best candidate. Candidates
    in ``equals`` have no more coefficients than the best candidate; those in ``larger`` have more
    coefficients."""

    equals: tuple[str, ...]
    larger: tuple[str, ...]

    @property
    def all_names(self) -> tuple[str, ...]:
        """Names of both groups."""
        return (*self.equals, *self.larger)


def similar_to(
    best: Candidate, others: Sequence[Candidate], *, unspecific: bool = False
) -> Similar:
    """Find the candidates whose columns explain the same error as the best candidate.

    ``unspecific``: if the best candidate names a cause, also include candidates that only describe
    the observation.
    """
    equals: list[str] = []
    larger: list[str] = []
    for other in others:
        if other.gain < LEAST_SHARE * best.gain or other.name == best.name:
            continue
        described = unspecific or best.effect.unspecific or _is_enough(other, best)
        if other.effect.unspecific and not described:
            continue
        if not stands_in(best, other) or not _takes_its_error(other, best):
            continue
        (larger if other.rank > best.rank else equals).append(other.name)
    return Similar(tuple(equals), tuple(larger))


def adds(item: Candidate, other: Candidate, *, searched: bool = True) -> bool:
    """Tell whether ``item`` still gains more than chance when ``other`` is in the model.

    ``searched``: whether to correct the gain for the search of ``item``; False if the search
    parameters follow from ``other``. Both gains use the same noise: the noise estimated with
    ``item`` in the model or, if that noise was not estimated, with ``other`` in the model.
    """
    gain, rank = _gain_with(other, item)
    freedom = min(item.freedom, other.freedom)
    p_value = corrected_p_value(gain, rank, item.trials if searched else 1.0, 1, freedom)
    return p_value < NOTHING_LEFT_P


def _gain_with(other: Candidate, item: Candidate) -> tuple[float, int]:
    """Return the gain and the rank of ``item`` if ``other`` is in the model.

    A model with both effects is at least as likely as the model with ``item`` alone. If the noise
    was estimated anew for both, the gain is therefore at least the difference of their gains.
    """
    known = item.evidence or other.evidence
    solution, share = other.solution, 1.0
    if known is not None:
        score = known.base.score(other.effect, other.nonlinear)
        solution = known.base.solution_with(other.effect, other.nonlinear, score)
        alone = known.base.score(item.effect, item.nonlinear).gain
        # The gain is scaled to ``item.gain``, for which the noise was estimated anew both without
        # and with the effect.
        share = item.gain / max(alone, 1e-300)
    left = Residuals(solution).score(item.effect, item.nonlinear)
    gain = left.gain * share
    if item.evidence is not None and other.evidence is not None and left.rank:
        gain = max(gain, item.gain - other.gain)
    return gain, left.rank


def _takes_its_error(other: Candidate, best: Candidate) -> bool:
    """Tell whether ``other`` in the model takes at least LEAST_SHARE of the gain of ``best``.

    If the best effect is hardly significant, its remaining gain is chance even if the other effect
    explains only a small part of the error; :func:`stands_in` alone would then accept the other
    effect.
    """
    return _gain_with(other, best)[0] <= (1.0 - LEAST_SHARE) * best.gain


def is_apart(item: Candidate, other: Candidate) -> bool:
    """Tell whether ``item`` loses less than OF_THE_SAME_KIND of its gain if ``other`` is in the
    model."""
    return _gain_with(other, item)[0] > (1.0 - OF_THE_SAME_KIND) * item.gain


def lead(item: Candidate, other: Candidate) -> float:
    """Return twice the log of the evidence of ``item`` divided by the evidence of ``other``.

    Both effects have the same noise, and each effect is a family of coefficients of one size
    (:func:`family_gain`). A BIC would penalise the 23 faces of a polygon as if each face had a size
    of its own.
    """
    known = item.evidence or other.evidence
    if known is None:
        return item.delta_bic - other.delta_bic
    gains = []
    for one in (item, other):
        score = known.base.score(one.effect, one.nonlinear)
        gains.append(family_gain(score) - 2.0 * float(np.log(max(one.trials, 1.0))))
    return gains[0] - gains[1]


def family_gain(score: Score) -> float:
    """Return twice the log of the largest evidence with coefficients b ~ N(0, s²·1), s free.

    Let λ be the eigenvalues of the information and z² the gains along its eigenvectors. Then the
    result is the largest Σ s²λ·z²/(1 + s²λ) − log(1 + s²λ) (random effects; Harville, J. Am. Stat.
    Assoc. 72 (1977) 320).
    """
    values, vectors = np.linalg.eigh(score.information)
    determined = values > RANK_TOLERANCE * max(float(values.max(initial=0.0)), 1e-300)
    if not determined.any():
        return 0.0
    values = values[determined]
    gains = (vectors[:, determined].T @ score.moment) ** 2 / values

    def loss(log_square: float) -> float:
        ratio = np.exp(log_square) * values
        return -float(np.sum(gains * ratio / (1.0 + ratio) - np.log1p(ratio)))

    middle = -float(np.log(np.median(values)))
    best = minimize_scalar(loss, bounds=(middle - FAR, middle + FAR), method="bounded")
    return max(0.0, -float(best.fun))


def stands_in(best: Candidate, other: Candidate) -> bool:
    """Tell whether the best effect, with ``other`` in the model, adds at most the gain that its
    search finds by chance."""
    return not adds(best, other)


def without_unspecific(found: Sequence[Candidate]) -> list[Candidate]:
    """Omit each effect that only describes the observation if a cause explains the same error.

    A motion of the axis also changes the reading of head 1: if only another head shows the line,
    the line stays.
    """
    specific = [item for item in found if not item.effect.unspecific]
    return [
        item
        for item in found
        if not item.effect.unspecific or not any(_explained(item, other) for other in specific)
    ]


def _explained(line: Candidate, other: Candidate) -> bool:
    if _is_enough(line, other):
        return False
    return stands_in(line, other) or of_its_order(line, other)


def _is_enough(line: Candidate, cause: Candidate) -> bool:
    """Tell whether a line of some heads explains all that a motion of the axis explains.

    With a reference, which shows the reading of head 1, the motion has more coefficients than the
    line. With two heads and no reference, both effects are one wave, so that the line is not a
    simpler explanation.
    """
    if not cause.effect.moves_axis or cause.rank <= line.rank:
        return False
    return line.gain >= LEAST_SHARE * cause.gain and not adds(cause, line, searched=False)


def of_its_order(line: Candidate, other: Candidate) -> bool:
    """Tell whether the other effect has an integer order within the resolution of the line's order,
    and explains most of the line.

    The integer order is the disc order that the other effect searched, or one of the orders of an
    axis motion. A line has a size and a phase for each head, so that it also fits small changes of
    an order of the disc: an eccentricity of 80″ changes the phase of order 120 by 0.05 rad. The
    result is True only if the line gains as much at the integer order as at its own order.
    """
    whole = _whole_order(line, other)
    if whole is None or line.nonlinear.get("in_time"):
        return False
    known = line.evidence or other.evidence
    order = line.nonlinear.get("order", 0.0)
    if known is None or abs(order - whole) > known.base.observations.order_resolution:
        return False
    base = known.base
    own = base.score(line.effect, line.nonlinear).gain
    there = {**line.nonlinear, "order": whole}
    if own - base.score(line.effect, there).gain > SEPARATING_GAIN:
        return False
    score = base.score(other.effect, other.nonlinear)
    with_other = Residuals(base.solution_with(other.effect, other.nonlinear, score))
    return with_other.score(line.effect, there).gain < OF_THE_SAME_KIND * own


def _whole_order(line: Candidate, other: Candidate) -> float | None:
    """Return the integer order of the other effect that may be the order of the line; None if it
    has no such order."""
    if other.effect.search_kind == "disc_order":
        return other.nonlinear["order"]
    nearest, own = round(line.nonlinear.get("order", 0.0)), other.effect.settings.get("orders")
    is_own = other.effect.moves_axis and isinstance(own, Sequence) and nearest in own
    return float(nearest) if is_own else None
