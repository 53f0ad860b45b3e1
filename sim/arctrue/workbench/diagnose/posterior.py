"""The probabilities of a diagnosis, consistent with the rules that gave its verdict."""

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
    untold,
)

PARTS_ADVANTAGE = 10.0
"""BIC by which a product of parts must beat the whole catalogue: odds of about 150 to 1, "very
strong" on the scale of Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773."""
SILENT = frozenset({"bad_data", "cannot_tell"})
SAID = {"unknown": [UNKNOWN], "adequate": [NONE], "cannot_tell": [NONE]}
"""What a verdict without an effect gives its probability to."""
CLASS_SHARE = 0.95
"""A class is the fewest hypotheses that hold so much of the probability: where ``unknown`` holds it
alone, no effect is of the class (a credible set of 95 %)."""
ONE_EFFECT_SHARE = 0.5
"""The same for a class of one effect: what is said must be the likelier of the two."""
A_LITTLE = 1e-3
"""Of a probability, or of its logarithm: what is said stays ahead by so much, against rounding."""
LEVEL = 0.01
"""Share by which a rival of the first of a class may be behind, where the set cannot tell the two
apart: the rules made them equal but for A_LITTLE, and they stay so."""
LEAST_OF_A_NAME = 0.8
"""Probability from which on one name is said: a false name is taken to cost four times what it
costs to name a class where one name would do."""


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
    """Of every effect that was tested, ``none`` and ``unknown``, as far as the rules leave it open;
    the sum is 1.

    ``look_alikes`` of the first of the class, which the set cannot test, are as probable as it is.
    ``product`` is the best product of parts where it is none of the candidates in other words;
    ``excluded`` are effects that fit and that held-out rows, passes or speeds speak against; the
    first of the class may be one of them, and ``unknown`` is then as likely as it is;
    ``confounded``: the product is the first growing with another condition, as likely as it is;
    ``near_tie`` and ``advantage`` are the ΔBIC by which the rules prefer names to products, and
    products to names.
    """
    effects = len(candidates) + untestable
    share = float(np.log(prior(effects)))
    if verdict in SILENT:
        weights = untold(len(candidates), untestable)
        return normalised(weights | {item.name: share for item in candidates})
    evidence = {item.name: share + log_evidence(_weighed(item)) for item in candidates}
    # What a rule excludes fits all the same: something like it is there.
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
        unknown = min(unknown, none)
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
        # The first explains the lack of fit as well, which is that of the model without it: the
        # stranger is no likelier.
        stranger = min(stranger, first - A_LITTLE)
        unknown = float(np.logaddexp.reduce([stranger, of_product, *suspects]))
        # Against one effect by its own odds; where several explain the rows alike, none of them is
        # excluded by what is ahead of each by less than the rules ask of a product.
        most = 0.5 * advantage if len(effect_class) == 1 else 0.0
        # The first of a class may be excluded only because it does not show at every speed: it is
        # then its own suspect, as likely as itself, and needs a rival of its own to be beaten.
        suspect = effect_class[0] in excluded
        others = [judged[name] for name in judged if name in excluded - set(effect_class)]
        rival = float(np.logaddexp.reduce([of_product, *others]))
        if confounded or (suspect and rival < first):
            # No likelier than the first.
            most = -A_LITTLE
        unknown = min(unknown, first - 0.5 * near_tie if named else first + most)
        for name, value in weights.items():
            if name not in effect_class:
                # Beside the first it adds nothing, or the first adds to it: at such a p.
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
    """The probabilities with which an answer is stated; the sum is 1.

    ``found``: those of the evidence; ``members``: the class of the answer; ``confidence``: how
    often such answers are right (:mod:`calibrated`), None where that is not known. The first of the
    class, ``unknown`` or ``none`` gets it; ``none`` of an answer that cannot tell, as nothing that
    the set could show is then likeliest. What effects and ``none`` lose goes to ``unknown``, what
    ``unknown`` loses to the effects; what an answer gains comes from all others in proportion, so
    that a class has at least as much as its first. The first of a class gains nothing while a rival
    is level with it. No answer falls behind what it contradicts.
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
    # Ahead of an heir v after it: k·held ≥ v + (1 − k)·part; of any other k·held ≥ v.
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
    """Of candidates whose own noise was not estimated: their gain has the noise beside the first.

    It is known with the first one's degrees of freedom, not without limit.
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
