"""Compares two candidates that may explain the same error."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate, explained_arcsec, happens_once
from arctrue.workbench.diagnose.classes import adds, lead, stands_in
from arctrue.workbench.diagnose.lack_of_fit import LACK_OF_FIT
from arctrue.workbench.diagnose.survey import Survey
from arctrue.workbench.inference.canonical_correlation import canonical_correlations

NEAR_TIE = 6.0
"""ΔBIC by which an effect must be ahead of a product of parts that explains the same error: odds of
20 to 1, "strong" on the scale of Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773."""
SAME_GAIN = 0.01
"""Two gains count as gains of the same columns if their relative difference is less than this; a
search determines the last digits of a gain only approximately."""
REFUSED_P = LACK_OF_FIT
"""An effect that fits but must not be named counts as a lack of fit if its p is below this value,
which equals the limit of a sure lack of fit."""
LOOK_ALIKE = 0.5
"""Two effects compete for the same error if their canonical correlation exceeds this value. ΔBIC
and the classes, not the size, then decide between the two."""


def is_smaller(item: Candidate, regular: Candidate) -> bool:
    """Tell whether the candidate explains less than a regular cause, or is a drift or event, which
    is listed apart."""
    return happens_once(item) or explained_arcsec(item) < explained_arcsec(regular)


def compete(survey: Survey, one: Candidate, other: Candidate) -> bool:
    """Tell whether the two effects have so similar columns that they compete for the same error."""
    return correlation(survey, one, other) > LOOK_ALIKE


def correlation(survey: Survey, one: Candidate, other: Candidate) -> float:
    """Return the largest canonical correlation of two effects with the model projected out."""
    found = canonical_correlations(survey.residuals, one.term, other.term)
    return float(np.max(found, initial=0.0))


def is_sure(item: Candidate) -> bool:
    """Tell whether the candidate, with the noise estimated anew, is as significant as a sure lack
    of fit."""
    return item.evidence is not None and item.p_corrected < REFUSED_P


def same_by_definition(best: Candidate, product: Candidate) -> bool:
    """Tell whether the product equals the effect by definition, and not only on the rows of this
    set."""
    if best.effect.unspecific and product.effect.unconditional_orders:
        return True
    if best.effect.in_parts and set(product.effect.parts) == set(best.effect.in_parts):
        return True
    equal_here = product.rank == best.rank and abs(product.gain / best.gain - 1.0) < SAME_GAIN
    return equal_here and not best.lacking_variety


def contains(best: Candidate, product: Candidate) -> bool:
    """Tell whether the effect explains the error of the product, and more than the product."""
    return stands_in(product, best) and adds(best, product)


def large_enough(real: list[Candidate]) -> Candidate | None:
    """Return the first of ``real``, or a larger effect that contains it and adds more than
    chance."""
    if not real:
        return None
    best, rest = real[0], list(real[1:])
    while rest:
        larger = [item for item in rest if item.rank > best.rank and stands_in(best, item)]
        found = next(
            (item for item in larger if adds(item, best) or lead(item, best) > NEAR_TIE), None
        )
        if found is None:
            break
        best = found
        rest.remove(found)
    return best
