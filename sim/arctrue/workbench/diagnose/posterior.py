"""The probabilities of a diagnosis, consistent with the rules that gave its verdict."""

from __future__ import annotations

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
    inadequacy,
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
CLASS_SHARE = 0.95
"""A class is the fewest hypotheses that hold so much of the probability: where ``unknown`` holds it
alone, no effect is of the class (a credible set of 95 %)."""
ONE_EFFECT_SHARE = 0.5
"""The same for a class of one effect: what is said must be the likelier of the two."""
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
    ways: int = 0,
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
    suspects = [evidence[name] for name in evidence if name in excluded]
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
        # The first explains the lack of fit as well, which is that of the model without it.
        unknown = float(np.logaddexp.reduce([min(stranger, first), of_product, *suspects]))
        # Against one effect by its own odds; where several explain the rows alike, none of them is
        # excluded by what is ahead of each by less than the rules ask of a product.
        most = 0.5 * advantage if len(effect_class) == 1 else 0.0
        # The first of a class may be excluded only because it does not show at every speed: it is
        # then its own suspect, as likely as itself, and needs a rival of its own to be beaten.
        suspect = effect_class[0] in excluded
        others = [evidence[name] for name in evidence if name in excluded - set(effect_class)]
        rival = float(np.logaddexp.reduce([of_product, *others]))
        if confounded or (suspect and rival < first):
            # No likelier than the first once the share for an inadequate model is given to it:
            # equal at −2s/(1 − s).
            share = inadequacy(verdict, ways)
            most = -2.5 * share / (1.0 - share)
        unknown = min(unknown, first - 0.5 * near_tie if named else first + most)
        for name, value in weights.items():
            if name not in effect_class:
                # Beside the first it adds nothing, or the first adds to it: at such a p.
                weights[name] = min(value, first + float(np.log(NOTHING_LEFT_P)))
            else:
                weights[name] = min(value, first)
        weights |= dict.fromkeys(look_alikes, first)
    return normalised({NONE: none, UNKNOWN: unknown} | weights)


def allowed_for(
    found: dict[str, float], verdict: str, candidates: list[Candidate], ways: int = 0
) -> dict[str, float]:
    """The same less what model and rules cannot claim: it goes from effects and from ``none`` to
    ``unknown``, and from ``unknown`` to the effects.

    ``ways``: in so many is the set unlike those on which wrong answers were counted.
    """
    share = inadequacy(verdict, ways)
    others = [item.name for item in candidates] if verdict == UNKNOWN else [UNKNOWN]
    if verdict in SILENT or not others:
        return found
    said = {UNKNOWN: UNKNOWN, "adequate": NONE}.get(verdict)
    if said is not None:
        # No more than leaves it the likeliest: what is said is not contradicted.
        ahead = 0.9 * max(found[said] - max(found[name] for name in others), 0.0)
        share = min(share, ahead / (ahead + 1.0 / len(others)))
    names = [value for name, value in found.items() if name not in (NONE, UNKNOWN)]
    if verdict == "named" and names:
        # How unlike a set is changes how sure a name is, not whether it is one.
        share = min(share, max(inadequacy(verdict), 1.0 - LEAST_OF_A_NAME / max(names)))
    elif verdict == "ambiguous" and names and max(names) > found[UNKNOWN]:
        ahead = max(names) - found[UNKNOWN]
        share = min(share, max(inadequacy(verdict), ahead / (ahead + 1.0)))
    kept = {name: (1.0 - share) * value for name, value in found.items()}
    return kept | {name: kept[name] + share / len(others) for name in others}


def _weighed(item: Candidate) -> Weighed:
    return Weighed(item.gain, item.rank, item.charged_trials, item.rows, item.freedom)


__all__ = ["allowed_for", "posterior"]
