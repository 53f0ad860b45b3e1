"""Calculates the probabilities of a diagnosis so that they agree with the rules that gave its
verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.classes import NOTHING_LEFT_P
from arctrue.workbench.diagnose.probabilities import (
    NONE,
    PRIOR_NONE,
    PRIOR_PRODUCT,
    PRIOR_STRANGER,
    UNKNOWN,
    Weighed,
    log_evidence,
    log_evidence_of_p,
    normalised,
    prior,
    prior_weights,
)

PARTS_ADVANTAGE = 10.0
"""ΔBIC by which a product of parts must be ahead of the whole catalogue: odds of about 150 to 1,
"very strong" on the scale of Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773."""
SILENT = frozenset({"bad_data", "cannot_tell"})
SAID = {"unknown": [UNKNOWN], "adequate": [NONE], "cannot_tell": [NONE]}
"""Hypotheses whose probability is stated with a verdict without an effect."""
CLASS_SHARE = 0.95
"""Probability of the smallest set of hypotheses that forms the class (a credible set of 95 %). If
``unknown`` alone has this probability, no effect belongs to the class."""
ONE_EFFECT_SHARE = 0.5
"""A class of one effect is stated if P(unknown)/(P(unknown) + P(effect)) is at most this value;
otherwise ``unknown`` is more probable than the effect."""
A_LITTLE = 1e-3
"""Margin that is added to a probability, or to its logarithm, so that the answer stays the most
probable one in spite of rounding."""
LEVEL = 0.01
"""Largest relative difference at which the probabilities of a rival and of the first effect of a
class count as equal. The rules make the two equal except for A_LITTLE."""
LEAST_OF_A_NAME = 0.8
"""Smallest probability with which a single name is stated. A false name is assumed to cost four
times as much as a class that is stated where a single name would be right."""


def posterior(
    verdict: str,
    candidates: list[Candidate],
    untestable: int,
    *,
    effect_class: list[str],
    look_alikes: list[str],
    product: Candidate | None,
    excluded: frozenset[str],
    lack_of_fit_p: float,
    near_tie: float,
    advantage: float,
    confounded: bool = False,
) -> dict[str, float]:
    """Return the probability of every tested effect, ``none`` and ``unknown``, within the bounds of
    the rules.

    The sum is 1. ``look_alikes`` are effects that the set cannot test and that look like the first
    of the class; they get its probability. ``product`` is the best product of parts, unless it
    equals one of the candidates. ``excluded`` are effects that fit but that held-out rows, passes
    or speeds contradict; if the first of the class is such an effect, ``unknown`` is as likely as
    the first. ``confounded``: the product is the first effect with another condition as its factor,
    and as likely as the first. ``near_tie`` is the ΔBIC by which the rules prefer a name to a
    product, ``advantage`` the ΔBIC by which they prefer a product to a name.
    """
    effects = len(candidates) + untestable
    share = float(np.log(prior(effects)))
    if verdict in SILENT:
        weights = prior_weights(len(candidates), untestable)
        return normalised(weights | {item.name: share for item in candidates})
    evidence = {item.name: share + log_evidence(_weighed(item)) for item in candidates}
    # An effect that a rule excludes fits the rows nevertheless, because the real, unknown error
    # resembles it.
    judged = evidence | _as_uncertain_as_the_first(candidates, effect_class, share)
    suspects = [judged[name] for name in judged if name in excluded]
    weights = {
        name: min(value, share) if name in excluded else value for name, value in evidence.items()
    }
    none = float(np.log(PRIOR_NONE))
    stranger = float(np.log(PRIOR_STRANGER)) + log_evidence_of_p(lack_of_fit_p)
    of_product = -np.inf
    if product is not None:
        of_product = float(np.log(PRIOR_PRODUCT)) + log_evidence(_weighed(product))
    unknown = float(np.logaddexp.reduce([stranger, of_product, *suspects]))
    if verdict == "adequate":
        # The rows say nothing about effects that the set cannot test: these keep their prior
        # probability, as part of ``unknown``.
        untested = float(np.log(untestable)) + share if untestable else -np.inf
        unknown = min(float(np.logaddexp(unknown, untested)), none)
        weights = {name: min(value, none) for name, value in weights.items()}
    elif verdict == "unknown":
        p_value = lack_of_fit_p if product is None else product.p_corrected
        none = min(none, unknown - log_evidence_of_p(p_value))
        weights = {name: min(value, unknown - 0.5 * advantage) for name, value in weights.items()}
    else:
        first = weights[effect_class[0]] = evidence[effect_class[0]]
        p_value = next(item.p_corrected for item in candidates if item.name == effect_class[0])
        none = min(none, first - log_evidence_of_p(p_value))
        named = verdict == "named"
        # The first effect explains the lack of fit of the model without this effect, so that
        # ``unknown`` is at most as probable as the first effect.
        stranger = min(stranger, first - A_LITTLE)
        unknown = float(np.logaddexp.reduce([stranger, of_product, *suspects]))
        # ``unknown`` may be ahead of a single effect by the odds that the rules require of a
        # product. Where several effects explain the rows equally well, a smaller lead excludes no
        # effect, and ``unknown`` may not be more probable than the first.
        most = 0.5 * advantage if len(effect_class) == 1 else 0.0
        # The first effect of a class can be excluded only because it does not show at every speed.
        # It is then itself one of the excluded effects whose probability ``unknown`` includes, so
        # that only another rival can make ``unknown`` more probable.
        suspect = effect_class[0] in excluded
        others = [judged[name] for name in judged if name in excluded - set(effect_class)]
        rival = float(np.logaddexp.reduce([of_product, *others]))
        if confounded or (suspect and rival < first):
            # ``unknown`` is then at most as probable as the first effect.
            most = -A_LITTLE
        unknown = min(unknown, first - 0.5 * near_tie if named else first + most)
        for name, value in weights.items():
            if name not in effect_class:
                # An effect outside the class gains less than half as much as the first effect, or
                # the first effect still adds something to a model with this effect
                # (:func:`classes.similar_to`). The weight of such an effect is at most the share
                # NOTHING_LEFT_P of the weight of the first.
                weights[name] = min(value, first + float(np.log(NOTHING_LEFT_P)))
            else:
                weights[name] = min(value, first)
        weights |= dict.fromkeys(look_alikes, first)
    return normalised({NONE: none, UNKNOWN: unknown} | weights)


def stated(
    found: Mapping[str, float],
    verdict: str,
    members: Sequence[str],
    confidence: float | None,
) -> dict[str, float]:
    """Return the probabilities with which an answer is stated; the sum is 1.

    ``found``: the probabilities from the evidence; ``members``: the class of the answer;
    ``confidence``: the probability that such answers are right (:mod:`calibrated`), None where it
    is not known.

    The first effect of the class, ``unknown`` or ``none`` gets the confidence. ``none`` also gets
    it if the verdict is that the set cannot tell: most likely, the model then contains every effect
    that the set could show. Probability that effects and ``none`` lose is added to ``unknown``, and
    probability that ``unknown`` loses is added to the effects. Probability that an answer gains is
    taken from all others in proportion, so that a class has at least the probability of its first
    effect. The first of a class gains no probability if a rival is equally probable. An answer
    stays more probable than the hypotheses that it contradicts.
    """
    if confidence is None or not found:
        return dict(found)
    effects = [name for name in found if name not in (NONE, UNKNOWN)]
    said = SAID.get(verdict, list(members))
    first = found[said[0]]
    if confidence >= first:
        level = any(
            value >= (1.0 - LEVEL) * first for name, value in found.items() if name != said[0]
        )
        if first >= 1.0 or (verdict == "ambiguous" and level):
            return dict(found)
        share = (1.0 - confidence) / (1.0 - first)
        return {
            name: confidence if name == said[0] else share * value for name, value in found.items()
        }
    held = sum(found[name] for name in said) if verdict == "ambiguous" else first
    falling = effects if verdict == "ambiguous" else said
    heirs = effects if verdict == "unknown" else [UNKNOWN]
    if not heirs:
        return dict(found)
    part = sum(found[name] for name in falling) / len(heirs)
    # ``heirs`` get the probability that the answer loses. If the answer keeps the share k, it stays
    # ahead of an heir of probability v if k·held ≥ v + (1 − k)·part, and of others if k·held ≥ v.
    least = (max(found[name] for name in heirs) + part) / (held + part)
    others = set(found) - {*falling, *heirs} if verdict != "ambiguous" else set()
    least = max([least, *(found[name] / held for name in others)])
    kept = min(max(confidence / first, least + A_LITTLE), 1.0)
    return {
        name: value * (kept if name in falling else 1.0)
        + ((1.0 - kept) * part if name in heirs else 0.0)
        for name, value in found.items()
    }


def _as_uncertain_as_the_first(
    candidates: Sequence[Candidate], effect_class: Sequence[str], share: float
) -> dict[str, float]:
    """Return the log evidence of candidates for which the noise was not estimated anew.

    The gain of these candidates uses the noise that was estimated with the first effect in the
    model. This noise is not exactly known: it has the degrees of freedom of the first effect.
    """
    first = next((item for item in candidates if item.name in effect_class[:1]), None)
    if first is None:
        return {}
    return {
        item.name: share + log_evidence(replace(_weighed(item), freedom=first.freedom))
        for item in candidates
        if item.evidence is None
    }


def _weighed(item: Candidate) -> Weighed:
    return Weighed(item.gain, item.rank, item.charged_trials, item.rows, item.freedom)


__all__ = ["posterior", "stated"]
