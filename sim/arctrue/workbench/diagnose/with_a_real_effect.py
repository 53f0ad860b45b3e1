"""Gains and ΔBIC of candidates with the noise that was estimated with a real effect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from arctrue.workbench.diagnose.candidate import (
    Candidate,
    delta_bic,
    explained_arcsec,
    happens_once,
    is_line,
    rows_moved,
)
from arctrue.workbench.diagnose.classes import of_its_order
from arctrue.workbench.inference.canonical_correlation import canonical_correlations

FAR_BEHIND = 60.0
"""A candidate needs no noise estimate of its own if its ΔBIC is lower than that of a real effect by
more than this."""
SAME_BLOCK = 1e-6
"""Relative tolerance of a gain and of a canonical correlation; it allows for rounding in equal
columns."""


def _score_with(items: Sequence[Candidate], real: Candidate) -> None:
    """Score all candidates at once, so that :func:`_gain_with` can read the stored scores."""
    assert real.evidence is not None
    real.evidence.base.scores([(item.effect, item.nonlinear) for item in items])


def _gain_with(item: Candidate, real: Candidate) -> float:
    """Return the candidate's gain with the noise of a real effect, scaled like the effect's own
    gain.

    The scale is the ratio of the real effect's gain, for which the noise was estimated anew, to its
    gain in the score test.
    """
    assert real.evidence is not None
    scale = real.gain / max(real.evidence.score.gain, 1e-300)
    return real.evidence.base.score(item.effect, item.nonlinear).gain * scale


def bic_with(item: Candidate, real: Candidate) -> float:
    """Return ΔBIC of a candidate minus ΔBIC of a real effect, both with the noise of the real
    effect."""
    assert real.evidence is not None
    rows = rows_moved(item.size_arcsec, real.evidence.base.solution)
    return delta_bic(_gain_with(item, real), item.rank, item.trials, rows) - real.delta_bic


def may_come_before(items: Sequence[Candidate], real: Candidate) -> list[Candidate]:
    """Return the candidates with nearly the ΔBIC of the real effect, or with a larger gain.

    A candidate with a larger gain may be a larger effect that contains the real effect. A candidate
    that explains more error than a line may be named before the line, even with a far lower ΔBIC.
    The disc order at which a line was found is always included.
    """
    _score_with(items, real)
    return [
        item
        for item in items
        if bic_with(item, real) > -FAR_BEHIND
        or _gain_with(item, real) > real.gain
        or _is_larger_than_a_line(item, real)
        or (real.effect.unspecific and of_its_order(real, item))
    ]


def _is_larger_than_a_line(item: Candidate, real: Candidate) -> bool:
    return (
        is_line(real)
        and not is_line(item)
        and not happens_once(item)
        and explained_arcsec(item) > explained_arcsec(real)
    )


def best_with(items: Sequence[Candidate], real: Candidate) -> list[Candidate]:
    """Return the candidates, best first, by their ΔBIC with the noise of the real effect."""
    _score_with(items, real)
    return sorted(items, key=lambda item: -bic_with(item, real))


def with_noise_of(items: Sequence[Candidate], real: Candidate) -> list[Candidate]:
    """Give each candidate without its own evidence the gain with the noise of the real effect."""
    assert real.evidence is not None
    base = real.evidence.base
    _score_with([item for item in items if item.evidence is None], real)
    found = []
    for item in items:
        if item.evidence is None and (gain := _gain_with(item, real)) > item.gain:
            score = base.score(item.effect, item.nonlinear)
            rows = rows_moved(item.size_arcsec, base.solution)
            item = replace(
                item,
                gain=gain,
                rank=score.rank,
                solution=base.solution_with(item.effect, item.nonlinear, score),
                rows=rows,
                delta_bic=delta_bic(gain, score.rank, item.trials, rows),
            )
        found.append(item)
    return found


def same_columns(item: Candidate, real: Candidate) -> bool:
    """Tell whether both effects have the same block of columns up to a linear transformation, such
    as a warm centre and order 1 times the temperature."""
    assert real.evidence is not None
    if real.effect.search or item.rank != real.rank:
        return False
    base = real.evidence.base
    gain = base.score(item.effect, item.nonlinear).gain
    if abs(gain - real.evidence.score.gain) > SAME_BLOCK * real.evidence.score.gain:
        return False
    correlations = canonical_correlations(base, item.term, real.term)
    return bool(correlations.size == item.rank and correlations[-1] > 1.0 - SAME_BLOCK)
