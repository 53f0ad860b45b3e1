"""Rules of the set: they use the results of every stage, including the probabilities."""

from __future__ import annotations

from dataclasses import replace

from arctrue.base.percent import probability_percent
from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.facts import Facts
from arctrue.workbench.diagnose.next_measurement import (
    MORE_READINGS_THAN_COEFFICIENTS,
    RECORD_AGAIN,
    NextMeasurement,
)
from arctrue.workbench.diagnose.posterior import CLASS_SHARE, LEAST_OF_A_NAME, ONE_EFFECT_SHARE
from arctrue.workbench.diagnose.probabilities import UNKNOWN


def faulty_rows(facts: Facts) -> Decision | None:
    """The rows themselves are faulty."""
    if not facts.faults:
        return None
    return Decision("bad_data", faults=tuple(facts.faults), next=RECORD_AGAIN)


def unknown_noise(facts: Facts) -> Decision | None:
    """No channel has a stated uncertainty or three more readings than coefficients."""
    if facts.case is not None or facts.too_short is not None:
        return None
    why = "it has too few rows, compared with the model's coefficients, to show the noise"
    return Decision("cannot_tell", cannot_tell=why, next=MORE_READINGS_THAN_COEFFICIENTS)


def too_little_to_see(facts: Facts) -> Decision | None:
    """Nothing is found, but little was detectable, or the rows do not determine the model.

    Slow noise, few rows or missing data may hide an effect.
    """
    found = facts.blindness
    if found is None:
        return None
    measurement = NextMeasurement(found.next_measurement, found.next_measurement_kind)
    return Decision("cannot_tell", cannot_tell=found.reason, next=measurement)


def unknown_is_likelier(facts: Facts) -> Decision | None:
    """`unknown` has more than 95 % of the probability of `unknown` and the class (50 % for one
    effect)."""
    said, case, offered = facts.said, facts.case, facts.offered
    if said.verdict not in ("named", "ambiguous") or case is None:
        return None
    there = sum(offered.get(name, 0.0) for name in said.effect_class)
    least = ONE_EFFECT_SHARE if len(said.effect_class) == 1 else CLASS_SHARE
    if offered[UNKNOWN] <= least * (there + offered[UNKNOWN]):
        return None
    unknown = Decision("unknown", described=said.described, question=said.question, next=said.next)
    if said.described is not None:
        return unknown
    # The refused candidate that fits best, or, without one, the first of the class.
    refused = [item for item in case.ranked if item.name in case.excluded]
    return replace(
        unknown,
        resembles=max(refused or case.ranked[:1], key=lambda item: item.delta_bic),
        unlike="a cause outside the catalogue is more probable than any effect: "
        + probability_percent(offered[UNKNOWN]),
    )


def too_improbable_for_a_name(facts: Facts) -> Decision | None:
    """An effect would be named, but its probability is below 0.8."""
    said = facts.said
    if said.verdict != "named" or facts.offered[said.effect_class[0]] >= LEAST_OF_A_NAME:
        return None
    share = probability_percent(facts.offered[said.effect_class[0]])
    why = f"its probability of {share} is too low for a name"
    return replace(said, verdict="ambiguous", unconfirmed=why, further=None)
