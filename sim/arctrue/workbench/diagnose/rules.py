"""Decides the verdict by one table of rules: the first rule that applies gives the verdict.

Rules of the set come first; they use the results of every stage, including the probabilities. A
survey is the result of all tests with one model. Rules of the survey apply to every survey of a
diagnosis, also to the survey with the first effect in the model. The first sentence of each rule is
its line in docs/workbench.md, "How the verdict is reached".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from arctrue.base.percent import probability_percent
from arctrue.workbench.diagnose.candidate import RUNS_ARE_THE_SAMPLE, Candidate, happens_once
from arctrue.workbench.diagnose.case import AGAIN, DEEPEST, LACK_OF_FIT, NEAR_TIE, Case
from arctrue.workbench.diagnose.classes import (
    OF_THE_SAME_KIND,
    adds,
    stands_in,
    without_unspecific,
)
from arctrue.workbench.diagnose.decision import Decision, Verdict
from arctrue.workbench.diagnose.facts import Facts
from arctrue.workbench.diagnose.jumps import jumps_in_words, whole_counts
from arctrue.workbench.diagnose.next_measurement import (
    AT_ANOTHER_SPEED,
    AT_ONE_SPEED,
    CLAMPED_AGAIN,
    LONGER_AND_BACK,
    LOOK_AT_THE_STAND,
    MORE_READINGS_THAN_COEFFICIENTS,
    OF_PARTS,
    ONE_MORE_DIGIT,
    RECORD_AGAIN,
    SLOWER_WITH_THE_INDEX,
    TURN_THE_POLYGON,
    TURN_THE_REFERENCE,
    WITH_THE_INDEX,
    NextMeasurement,
    Question,
)
from arctrue.workbench.diagnose.of_the_runs import (
    LEAST_OFFSETS,
    offsets_are_large,
    offsets_follow,
    runs_differ_with,
)
from arctrue.workbench.diagnose.own_tests import (
    follows_the_reading,
    further_motion,
    one_pattern,
    shape_with_corners,
)
from arctrue.workbench.diagnose.posterior import (
    CLASS_SHARE,
    LEAST_OF_A_NAME,
    ONE_EFFECT_SHARE,
    PARTS_ADVANTAGE,
)
from arctrue.workbench.diagnose.probabilities import UNKNOWN
from arctrue.workbench.diagnose.rounding import rounded_at_the_stations
from arctrue.workbench.diagnose.same_ramp import same_ramp
from arctrue.workbench.diagnose.slips_alike import slips_alike
from arctrue.workbench.diagnose.speed_ladder import not_in_proportion
from arctrue.workbench.diagnose.survey import Survey
from arctrue.workbench.inference.canonical_correlation import canonical_correlations
from arctrue.workbench.inference.forward.cycles import p_among_cycles
from arctrue.workbench.inference.forward.mountings import describes_mountings
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.same_place import RepeatedError
from arctrue.workbench.inference.significance import SIGNIFICANCE

LEAST_EXCESS = 0.25
"""A model is not adequate if its residuals exceed the noise by at least this share of the noise and
its lack of fit is significant, even if no effect describes the residuals."""

RISES = 1e-3
"""Smallest relative rise of the RMS that the printed figures show (three or four digits). The rise
is averaged over the channels: a fall in one channel compensates for a rise in another channel,
which a further cause may explain."""
LINES = frozenset({"line", "frequency", "unwrapped_order"})
"""Kinds of search that find a line (a sine of one order or frequency); an oscillation that noise
drives may look like a line."""
OF_AN_OSCILLATION = 0.75
"""A line or a product of parts explains an oscillation if it gains more than this share of the
oscillation's gain. A line explains all of a sine whose amplitude or phase changes little. It
explains about a third of an oscillation that loses its phase twenty times in the record and
therefore has the width of six frequencies that the record separates."""
LEAST_TAKEN = 0.1
"""Smallest share of the error's mean square above the noise that an effect must remove; an effect
that removes less does not explain this error."""


# Rules of the set.


def faulty_rows(facts: Facts) -> Decision | None:
    """The rows themselves are faulty."""
    if not facts.faults:
        return None
    return Decision("bad_data", faults=tuple(facts.faults), next=RECORD_AGAIN)


def unknown_noise(facts: Facts) -> Decision | None:
    """No channel has three readings more than coefficients or a stated uncertainty."""
    if facts.case is not None or facts.too_short is not None:
        return None
    why = "it has too few rows for its coefficients to show the noise"
    return Decision("cannot_tell", cannot_tell=why, next=MORE_READINGS_THAN_COEFFICIENTS)


def too_little_to_see(facts: Facts) -> Decision | None:
    """Nothing is found, but little could have been, or the rows do not determine the model.

    Slow noise, few rows or missing data may hide an effect.
    """
    found = facts.blindness
    if found is None:
        return None
    measurement = NextMeasurement(found.next_measurement, found.next_measurement_kind)
    return Decision("cannot_tell", cannot_tell=found.reason, next=measurement)


def unknown_is_likelier(facts: Facts) -> Decision | None:
    """`unknown` has 95 % of the probability that it shares with the class (50 % for a single
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
        unlike="a cause that no catalogue has is more probable than any effect, "
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


# Rules of a survey.


def described_by_parts(case: Case) -> Decision | None:
    """A product of parts leads the whole catalogue by more than ΔBIC 10."""
    if case.product is None or case.ahead <= PARTS_ADVANTAGE:
        return None
    left = case.with_it(case.product) if case.depth == 1 else None
    further = None if left is None else left.decision
    if further is None or further.verdict not in ("named", "ambiguous"):
        return Decision("unknown", described=case.product)
    return Decision("unknown", described=case.product, further=further)


def jumped_once(case: Case) -> Decision | None:
    """A jump explains more than any effect or product of parts."""
    steps = case.survey.findings.steps
    step = max(steps, key=lambda item: item.gain, default=None)
    if step is None or (case.best is not None and case.best.regular is not None):
        return None
    rivals = [item.gain for item in (case.best, case.product) if item is not None]
    if any(gain > 2.0 * step.gain - NEAR_TIE for gain in rivals):
        return None
    count_arcsec = case.survey.base.observations.count_arcsec
    alike = {}
    if whole_counts(steps, count_arcsec):
        untestable = case.survey.untestable.items()
        alike = {name: lacking for name, lacking in untestable if case.effects[name].step_at}
    return Decision(
        "unknown",
        seen=jumps_in_words(steps, count_arcsec),
        look_alikes=alike,
        next=LOOK_AT_THE_STAND,
    )


def loses_counts_again(case: Case) -> Decision | None:
    """R₂ − R₁ changes three times or more by the same whole number of counts."""
    if case.depth > 1:
        return None
    found = slips_alike(case.survey.base)
    if found is None or found.size_arcsec < case.survey.matters_arcsec:
        return None
    return Decision(
        "unknown",
        seen=found.words(),
        next=SLOWER_WITH_THE_INDEX if found.only_when_fast else WITH_THE_INDEX,
    )


def moved_between_cycles(case: Case) -> Decision | None:
    """The offset of the reference changes between cycles or runs, or its order 1 between runs;
    neither the best effect nor the best product of parts explains these changes better than
    chance."""
    change, best = case.survey.findings.cycles, case.best
    if change is not None and change.order_1_arcsec:
        tried = [item for item in (best, case.product) if item is not None]
        if any(describes_mountings(case.survey.base, item.solution) for item in tried):
            return None
        return Decision("unknown", seen=change.words(), next=CLAMPED_AGAIN)
    if change is None or best is None or best.second_of_runs is not None:
        return None
    tried = [item for item in (best, case.product) if item is not None]
    if any(p_among_cycles(case.survey.base, item.solution) < SIGNIFICANCE for item in tried):
        return None
    return Decision("unknown", seen=change.words(), next=LOOK_AT_THE_STAND)


def driven_by_noise(case: Case) -> Decision | None:
    """The noise has a damped oscillation, or a part of a log has a line; lines and products of
    parts gain less than three quarters as much, other effects less than a tenth as much."""
    best, product = case.best, case.product
    flexible = best is not None and _only_lines(case, best)
    if product is not None and case.ahead > PARTS_ADVANTAGE:
        best, flexible = product, True
    if best is None:
        if not (case.seen or case.refused or product or _not_white(case.survey)):
            return None
    elif best.regular is not None or not (flexible or _leaves_colour(case)):
        return None
    found = case.oscillation
    if found is None:
        return None
    if best is not None and found.channel not in _channels_moved(best, case.survey):
        return None
    most = (OF_AN_OSCILLATION if flexible else LEAST_TAKEN) * 2.0 * found.gain
    if best is not None and best.gain > most:
        return None
    return Decision("unknown", seen=found.words(), oscillation=found)


def _only_lines(case: Case, best: Candidate) -> bool:
    """The best effect is a line, or far behind a line that other rows contradict."""
    refused = case.refused
    if best.effect.search_kind in LINES:
        return True
    return (
        refused is not None
        and refused.effect.search_kind in LINES
        and refused_is_ahead(case) is not None
    )


def _leaves_colour(case: Case) -> bool:
    """With the best effect in the model, a channel is still not white."""
    return case.with_best is not None and _not_white(case.with_best.survey)


def _not_white(survey: Survey) -> bool:
    tests = (survey.residuals.capture_whiteness, survey.residuals.reference_whiteness)
    p_values = [
        *survey.lack_of_fit.values(),
        *(t.autocorrelation_p for t in tests if t is not None),
    ]
    return survey.findings.oscillation is not None or min(p_values, default=1.0) < LACK_OF_FIT


def runs_change_alike(case: Case) -> Decision | None:
    """No effect is found, and the capture changes evenly within every run alike, also with the best
    product of parts in the model."""
    if case.best is not None or case.depth > 1:
        return None
    product = case.product
    found = same_ramp(case.survey.residuals if product is None else Residuals(product.solution))
    if found is None or found.rms_arcsec < case.survey.matters_arcsec:
        return None
    measurement = LONGER_AND_BACK if len(found.coordinates) == 1 else AT_ANOTHER_SPEED
    return Decision("unknown", seen=found.words(), next=measurement)


def shown_at_one_speed(case: Case) -> Decision | None:
    """The only effect that is found appears at one speed, but should appear at every speed."""
    if case.best is not None or not case.seen:
        return None
    first, refused = without_unspecific(case.seen)[0], case.refused
    if refused is not None and refused.delta_bic > first.delta_bic + PARTS_ADVANTAGE:
        return None
    return Decision(
        "ambiguous",
        first=first,
        effect_class=[first.name],
        unconfirmed="it appears at one of several speeds only, but should appear at each",
        next=AT_ONE_SPEED,
    )


def refused_is_ahead(case: Case) -> Decision | None:
    """Other rows contradict the effect that fits best by far, and the next one adds nothing."""
    refused, best = case.refused, case.best
    if refused is None or refused.delta_bic <= PARTS_ADVANTAGE:
        return None
    if best is not None and best.regular is not None:
        return None
    if best is not None and (
        refused.delta_bic - best.delta_bic <= PARTS_ADVANTAGE or adds(best, refused)
    ):
        return None
    why = case.survey.objection(refused) or "other speeds do not show it"
    return Decision("unknown", resembles=refused, unlike=why)


def left_undescribed(case: Case) -> Decision | None:
    """The model leaves a large and significant error that nothing describes."""
    if case.best is not None:
        return None
    places = case.survey.findings.places
    # As for an effect, the size of an error at single places is its size where it acts.
    at_places = {"reference": 0.0 if places is None else places.largest_arcsec}
    left = {
        channel: item.excess_arcsec
        for channel, item in case.survey.channels.items()
        if item.lack_of_fit_p is not None
        and item.lack_of_fit_p < LACK_OF_FIT
        and max(item.excess_arcsec, at_places.get(channel, 0.0))
        > max(case.survey.matters_arcsec, LEAST_EXCESS * item.noise_arcsec)
    }
    if not left:
        return None
    if places is None or "reference" not in left:
        return Decision("unknown", undescribed_arcsec=left)
    rows = case.survey.base.observations.reference
    of_faces = rows is not None and rows.faces is not None
    return Decision(
        "unknown",
        undescribed_arcsec=left,
        # Errors at a few places do not show that a named effect has another shape.
        seen=places.words() if places.spots else None,
        look_alikes=_alike_at_places(case, places),
        next=TURN_THE_POLYGON if of_faces else TURN_THE_REFERENCE,
    )


def _alike_at_places(case: Case, places: RepeatedError) -> dict[str, list[str]]:
    """Return the effects that this set cannot test and that look like an error of its places: those
    of single places of the disc, and those with a coefficient for each face of the polygon."""
    observations = case.survey.base.observations
    found = {}
    for name, lacking in case.survey.untestable.items():
        kind = case.effects[name]
        if kind.fixed_to_polygon and places.stations and observations.faces is not None:
            alike = len(kind().column_names(observations)) == observations.faces
        else:
            alike = kind.local_on_disc and bool(places.spots)
        if alike:
            found[name] = lacking
    return found


def jumped_or_not_white(case: Case) -> Decision | None:
    """No effect is found, but something jumped or the residuals are no known noise."""
    if case.best is not None:
        return None
    found = set(case.not_white) | ({"reference"} if case.not_noise else set())
    if not found:
        return None
    left = {
        channel: item.excess_arcsec
        for channel, item in case.survey.channels.items()
        if channel in found
    }
    return Decision("unknown", undescribed_arcsec=left)


def runs_follow_a_condition(case: Case) -> Decision | None:
    """No effect is found, but the offsets of the runs follow a condition and exceed the index."""
    if case.best is not None or case.depth > 1:
        return None
    found = offsets_follow(case.survey.residuals)
    if found is None or found.rms_arcsec < case.survey.matters_arcsec:
        return None
    seen = (
        f"the offsets of the runs follow the condition {found.part}; they scatter by "
        f"{found.rms_arcsec:.2g}″, the index by {found.index_arcsec:.2g}″"
    )
    kind, words = OF_PARTS.get(found.part, ("again", f"more runs at other values of {found.part}"))
    return Decision("unknown", seen=seen, next=NextMeasurement(words, kind))


def nothing_found(case: Case) -> Decision | None:
    """No effect and no product of parts is significant."""
    return Decision("adequate") if case.best is None else None


def rounded_by_the_display(case: Case) -> Decision | None:
    """The rounding of the reference's display explains the best effect."""
    best = case.best
    assert best is not None
    reference = case.survey.channels.get("reference")
    if reference is None or _channels_moved(best, case.survey) != ["reference"]:
        return None
    step = rounded_at_the_stations(best, reference.noise_arcsec)
    if step == 0.0:
        return None
    same = "changes with the error" if best.regular else "is the same at every visit of a station"
    why = (
        f"the readings of the reference are rounded to {step:.3g}″, and this rounding {same}: it "
        f"explains the error that resembles {best.name}"
    )
    return Decision("cannot_tell", cannot_tell=why, next=ONE_MORE_DIGIT)


def contradicts_itself(case: Case) -> Decision | None:
    """The best effect has values that its own physics excludes."""
    best = case.best
    assert best is not None
    solution = best.solution
    part = solution.part(len(solution.terms) - 1)
    why = best.effect.contradiction(
        solution.coefficients[part],
        solution.covariance[part, part],
        best.at_maximum.terms[-1].nonlinear,
        solution.observations,
    )
    if why is None and best.effect.search:
        found = best.at_maximum.parameters()[-1]
        why = best.effect.search_contradiction(found, solution.observations)
    if why is None:
        return None
    # The product that explains the same error as the best effect describes this error without its
    # cause.
    product = case.product if case.product is not None and stands_in(best, case.product) else None
    return _only_resembles(case, why, described=product)


def makes_it_worse(case: Case) -> Decision | None:
    """The best effect makes the error of its own channels larger when it is added.

    Its own channels are those in which it has columns.

    An effect that differs between runs only is in the offsets of the runs, whose error is not
    counted. A line that other blocks predict exists even if the RMS rises: with the line in the
    model, the table's orders fit slow noise differently, which can change the RMS by more than the
    line.
    """
    found = case.before_and_after
    if found is None or _of_the_runs(case):
        return None
    if case.best is not None and case.shown_by_parts(case.best):
        return None
    before, after = found
    if after.mean_log_ratio(before) <= RISES:
        return None
    said = " and ".join(
        f"{channel} {value:.4g}″ RMS ({before.rms_arcsec[channel]:.4g}″ before)"
        for channel, value in after.rms_arcsec.items()
    )
    # Least squares weights the rows by the noise, and the noise is estimated anew with the effect.
    why = "the rows, weighted by their noise, agree better with it, but their error rises"
    return _only_resembles(case, f"{why}: {said}")


def _of_the_runs(case: Case) -> bool:
    """Return True if the offsets of enough runs decide whether the best effect exists."""
    best = case.best
    if best is None or best.evidence is None:
        return False
    if best.second_of_runs is not None:
        return True
    if best.solution.observations.runs - best.rank < LEAST_OFFSETS:
        return False
    return best.evidence.index_share >= RUNS_ARE_THE_SAMPLE


def takes_little(case: Case) -> Decision | None:
    """The best effect removes less than a tenth of a sure excess, and no blocks confirm it.

    A line that other blocks of the rows predict exists, however large the remaining error is;
    further surveys search for that error. If a diagnosis then finds the same kind in every survey,
    and all these effects together remove less than a tenth, the error has another shape, and each
    of them is a part of this error. An effect that differs between runs only is in the offsets of
    the runs and removes nothing from the rows.
    """
    if case.best is None or case.shown_by_parts(case.best) or _of_the_runs(case):
        # Other blocks predict a line of a forward search, and other passes a reversal error.
        return None
    if case.best.share is not None:
        # An earlier test has refused a share of half or less.
        return _one_kind_takes_little(case)
    found, left = case.before_and_after, case.with_best
    if found is None or left is None:
        return None
    before, after = found
    said = _little_taken(
        case,
        left,
        before.rms_arcsec,
        after.rms_arcsec,
        {name: min(value, after.noise_arcsec[name]) for name, value in before.noise_arcsec.items()},
    )
    if said is None:
        return None
    why = f"of the error above the noise it removes only {said}"
    return _only_resembles(case, why, case.further)


def _one_kind_takes_little(case: Case) -> Decision | None:
    """Each effect that is found is of the kind of the first, and together they remove little."""
    assert case.best is not None
    deepest = case
    for _ in range(DEEPEST - 1):
        further = deepest.with_best
        if further is None or further.best is None or further.best.name != case.best.name:
            return None
        deepest = further
    before, after = case.survey.channels, deepest.survey.channels
    said = _little_taken(
        case,
        deepest,
        {name: item.residual_rms_arcsec for name, item in before.items()},
        {name: item.residual_rms_arcsec for name, item in after.items()},
        {name: min(item.noise_arcsec, after[name].noise_arcsec) for name, item in before.items()},
    )
    if said is None:
        return None
    why = (
        f"it is found {DEEPEST} times, and the first {DEEPEST - 1} together remove only {said} of "
        "the error above the noise"
    )
    return _only_resembles(case, why)


def _little_taken(
    case: Case,
    left: Case,
    before: Mapping[str, float],
    after: Mapping[str, float],
    noise: Mapping[str, float],
) -> str | None:
    """Return the shares of a sure excess that are removed, in words; None if one is a tenth or
    more."""
    taken = {}
    for channel, rms in before.items():
        rest = left.survey.channels[channel].lack_of_fit_p
        excess = rms**2 - noise[channel] ** 2
        if excess <= (LEAST_EXCESS * noise[channel]) ** 2:
            continue
        share = (rms**2 - after[channel] ** 2) / excess
        if share >= LEAST_TAKEN:
            return None
        # Otherwise the remaining error may be slow noise, which no effect removes.
        if rest is not None and rest < LACK_OF_FIT:
            taken[channel] = max(share, 0.0)
    if case.best is None or not set(taken) & set(_channels_moved(case.best, case.survey)):
        return None
    return " and ".join(f"{100.0 * share:.2g} % in the {name}" for name, share in taken.items())


def _channels_moved(item: Candidate, survey: Survey) -> list[str]:
    """Return the channel that an effect changes most, in units of the noise of its rows."""
    noise = {name: fit.noise_arcsec for name, fit in survey.channels.items()}
    return sorted(
        (name for name in item.moved_arcsec if name in noise),
        key=lambda name: -item.moved_arcsec[name] / max(noise[name], 1e-12),
    )[:1]


def moves_at_further_orders(case: Case) -> Decision | None:
    """With the best effect in the model, the axis still moves at orders that this effect lacks.

    A cam or tooth moves the axis at the multiples of its order.
    """
    if case.best is None or case.with_best is None:
        return None
    left = case.with_best.survey
    why = further_motion(case.best, left.residuals, left.matters_arcsec)
    return None if why is None else _only_resembles(case, why)


def leaves_its_own_kind(case: Case) -> Decision | None:
    """With the best effect in the model, an unknown error of about its size remains.

    An effect with a similar shape removes part of an error that the catalogue does not have: the
    faces of a polygon remove part of a flat track, a slip removes part of the knocks of a loose
    head.
    """
    assert case.best is not None
    if case.shown_by_parts(case.best):
        # The remaining error does not contradict a line that other blocks predict, or a reversal
        # error that other passes show; it is a further finding.
        return None
    left = case.further
    if left is None or not _unknown_within(left, case):
        return None
    if left.described is not None and _grows_with_a_column(case.best, left.described):
        return None
    return _only_resembles(
        case,
        "with it in the model an unknown error of about its size remains",
        left,
    )


def leaves_a_larger_slow_change(case: Case) -> Decision | None:
    """The best effect is a drift, and with it in the model a larger slow change of unknown form
    remains."""
    best, left = case.best, case.with_best
    assert best is not None
    if left is None or left.survey.findings.slow is None:
        return None
    if best.effect.step_at is not None or not happens_once(best):
        return None
    # The ends of a straight line with the RMS 1 are √12 apart.
    if left.survey.findings.slow.size_arcsec <= np.sqrt(12.0) * _largest(best):
        return None
    return _only_resembles(case, "with it in the model a larger slow change remains")


def _grows_with_a_column(best: Candidate, product: Candidate) -> bool:
    """Tell whether the product is the best effect times a further column: the effect then has no
    other shape."""
    column = product.effect.settings.get("column")
    own = set(best.effect.in_parts)
    return bool(own and column) and set(product.effect.parts) == own | {column}


def comes_again_and_again(case: Case) -> Decision | None:
    """The best effect is an event, and two more events of its kind and size exist.

    One slip is an accident; a head that steps again and again is loose, sticks, or is disturbed.
    """
    best = case.best
    assert best is not None
    if best.effect.step_at is None:
        return None
    left: Case | None = case
    event: Candidate | None = best
    for _ in range(AGAIN - 1):
        left = left.with_it(event) if left is not None else None
        event = None if left is None else left.once_more(best)
        if event is None:
            return None
    return _only_resembles(case, f"it occurs {AGAIN} times or more, at irregular instants")


def fails_its_own_test(case: Case) -> Decision | None:
    """The best effect is an order of a shape with corners, a constant although the runs differ, a
    delay whose offsets follow no straight line of the speed, or an error that follows the reading.

    A pattern with corners is not one order, an error that differs with the speed of the runs is not
    a constant, and an error that follows the reading of the reference is not an error of the table.
    """
    best = case.best
    assert best is not None
    why = one_pattern(*_disc_one_after_the_other(case))
    if why is None and best.effect.search_kind == "line":
        why = shape_with_corners(case.survey.findings.causes)
    if why is None and follows_the_reading(case.survey.residuals, best, NEAR_TIE):
        why = "it follows the reading of the reference, so that the reference's scale is nonlinear"
    if why is None:
        why = not_in_proportion(case.survey.base, best, OF_THE_SAME_KIND)
    further = case.further
    explained = further is not None and further.verdict in ("named", "ambiguous")
    if why is None and _of_the_runs(case) and case.with_best is not None and not explained:
        left = case.with_best.survey.residuals
        condition = runs_differ_with(left)
        if condition is not None and offsets_are_large(
            left, case.survey.residuals, OF_THE_SAME_KIND
        ):
            why = f"the runs still differ with the {condition}, by more than the index scatters"
    return None if why is None else _only_resembles(case, why)


def _disc_one_after_the_other(case: Case) -> tuple[list[float], int]:
    """Return the orders of the disc and the number of local defects, each found with the earlier
    ones in the model."""
    orders: list[float] = []
    places = 0
    left: Case | None = case
    while left is not None and left.best is not None:
        kind = left.best.effect.search_kind
        if kind == "disc_order":
            orders.append(left.best.nonlinear["order"])
        elif kind == "disc_place":
            places += 1
        else:
            break
        left = left.with_best
    return orders, places


def cannot_be_split(case: Case) -> Decision | None:
    """Other effects explain these rows as well, or the set lacks data that the name needs."""
    best, similar = case.best, case.similar
    assert best is not None
    stranger = case.stand_in
    near_tie = stranger is not None and case.ahead > -NEAR_TIE
    rivals = list(case.rivals)
    if not (best.lacking_variety or rivals or near_tie):
        return None
    if stranger is not None and (near_tie or not rivals):
        rivals.append(stranger)
    also = case.confounded_effect
    if also is not None and also not in rivals:
        rivals.append(also)
    found = Question(best, rivals or [case.others[name] for name in similar.larger])
    why = f"it needs {'; '.join(best.lacking_variety)}" if best.lacking_variety else None
    return _of_class(
        case,
        "ambiguous",
        described=stranger,
        unconfirmed=why,
        look_alikes=case.look_alikes if best.lacking_variety else None,
        question=found,
        also=also,
    )


def looks_like_untestable(case: Case) -> Decision | None:
    """An effect that this set cannot test would look the same."""
    found = case.look_alikes
    if not found:
        return None
    lacking = "; ".join(sorted({what for items in found.values() for what in items}))
    return _of_class(
        case,
        "ambiguous",
        look_alikes=found,
        unconfirmed=(
            f"{', '.join(found)} would look the same on these rows and cannot be tested: "
            f"the set lacks {lacking}"
        ),
        measurement=NextMeasurement(f"a set that has {lacking}", None),
    )


def grows_with_another(case: Case) -> Decision | None:
    """The effect may depend on another condition, which changed together with its own in this
    set."""
    best, other, also = case.best, case.confounded, case.confounded_effect
    assert best is not None
    if other is None:
        return None
    found = _of_class(
        case,
        "ambiguous",
        described=other if also is None else None,
        unconfirmed="the condition it depends on changed together with another one in this set",
        question=Question(best, [other]),
        also=also,
    )
    return replace(found, confounded=True)


def known_by_name(case: Case) -> Decision | None:
    """One effect is missing, and no other rule contradicts its name."""
    assert case.best is not None
    larger = [case.others[name] for name in case.similar.larger]
    return _of_class(case, "named", question=Question(case.best, larger) if larger else None)


def _only_resembles(
    case: Case, why: str, left: Decision | None = None, described: Candidate | None = None
) -> Decision:
    deepest = left
    while deepest is not None and deepest.verdict != "unknown":
        deepest = deepest.further
    if deepest is not None:
        described = deepest.described
    return Decision(
        "unknown",
        described=described,
        resembles=case.best,
        unlike=why,
        further=left,
    )


def _of_class(
    case: Case,
    verdict: Verdict,
    *,
    question: Question | None = None,
    measurement: NextMeasurement | None = None,
    described: Candidate | None = None,
    unconfirmed: str | None = None,
    look_alikes: dict[str, list[str]] | None = None,
    also: Candidate | None = None,
) -> Decision:
    best, names = case.best, list(case.similar.all_names)
    assert best is not None
    unseen = look_alikes or {}
    if also is not None and also.name not in names:
        names.append(also.name)
    return Decision(
        verdict,
        first=best,
        effect_class=[best.name, *names, *unseen],
        class_correlation={name: _correlation(case, best, case.others[name]) for name in names},
        described=described,
        unconfirmed=unconfirmed,
        look_alikes=unseen,
        question=question,
        next=measurement,
        further=case.further,
    )


def _correlation(case: Case, best: Candidate, other: Candidate) -> float:
    found = canonical_correlations(case.survey.residuals, best.term, other.term)
    return float(np.max(found, initial=0.0))


def _unknown_within(left: Decision, case: Case) -> bool:
    """Return True if an unknown error of the size of the first effect remains, also after further
    effects."""
    first = case.best
    assert first is not None
    if left.oscillation is not None:
        # An oscillation driven by noise may accompany any effect; if it is larger than the effect,
        # the effect is probably a part of the same unknown error.
        return left.oscillation.rms_arcsec > _largest(first)
    if left.seen is not None:
        # A single event is no evidence that the effect has another shape.
        return False
    if left.verdict != "unknown":
        return left.further is not None and _unknown_within(left.further, case)
    found = left.described or left.resembles
    if found is not None:
        # The remaining error must be large compared with the first effect both in units of the
        # noise and in arcseconds. If the repeats have little noise, the first test alone would let
        # a fiftieth of the error prevent the name.
        in_noise = found.gain > OF_THE_SAME_KIND * first.gain
        return in_noise and _largest(found) ** 2 > OF_THE_SAME_KIND * _largest(first) ** 2
    if not left.undescribed_arcsec:
        return True
    # The remaining error is compared with the largest of several sizes of the first effect. The
    # fall of the mean square counts, because slow noise may have absorbed the effect before it was
    # added. The change of another channel's prediction counts, because the effect may remove
    # nothing in this channel. An effect that only the offsets of the runs show removes nothing in
    # its own channel.
    of_the_runs = _of_the_runs(case)
    return any(
        after**2
        > OF_THE_SAME_KIND
        * max(
            case.survey.channels[channel].excess_arcsec ** 2 - after**2,
            _fall_of_square(case, channel),
            0.0,
            *(
                moved**2
                for name, moved in first.moved_arcsec.items()
                if name != channel or of_the_runs
            ),
        )
        for channel, after in left.undescribed_arcsec.items()
    )


def _fall_of_square(case: Case, channel: str) -> float:
    """Return the mean square that the best effect removes from the residual of a channel,
    arcsec²."""
    if case.with_best is None:
        return 0.0
    before, after = case.survey.channels[channel], case.with_best.survey.channels[channel]
    return before.residual_rms_arcsec**2 - after.residual_rms_arcsec**2


def _largest(item: Candidate) -> float:
    return max(item.moved_arcsec.values(), default=0.0)


@dataclass(frozen=True)
class Rule:
    """One rule, which is one line of the table of rules."""

    verdict: Verdict
    judge: Callable[[Any], Decision | None]
    """Function of the facts of a set, or of the case of a survey; it returns None if the rule does
    not apply."""
    of_survey: bool = True

    @property
    def says(self) -> str:
        """Sentence that states when the rule applies."""
        return (self.judge.__doc__ or "").partition("\n\n")[0].replace("\n   ", "")


RULES = (
    Rule("bad_data", faulty_rows, of_survey=False),
    Rule("cannot_tell", unknown_noise, of_survey=False),
    Rule("cannot_tell", too_little_to_see, of_survey=False),
    Rule("unknown", unknown_is_likelier, of_survey=False),
    Rule("ambiguous", too_improbable_for_a_name, of_survey=False),
    Rule("unknown", jumped_once),
    Rule("unknown", loses_counts_again),
    Rule("unknown", moved_between_cycles),
    Rule("unknown", driven_by_noise),
    Rule("unknown", runs_change_alike),
    Rule("unknown", described_by_parts),
    Rule("ambiguous", shown_at_one_speed),
    Rule("unknown", refused_is_ahead),
    Rule("unknown", left_undescribed),
    Rule("unknown", jumped_or_not_white),
    Rule("unknown", runs_follow_a_condition),
    Rule("adequate", nothing_found),
    Rule("cannot_tell", rounded_by_the_display),
    Rule("unknown", contradicts_itself),
    Rule("unknown", makes_it_worse),
    Rule("unknown", takes_little),
    Rule("unknown", moves_at_further_orders),
    Rule("unknown", leaves_its_own_kind),
    Rule("unknown", leaves_a_larger_slow_change),
    Rule("unknown", comes_again_and_again),
    Rule("unknown", fails_its_own_test),
    Rule("ambiguous", cannot_be_split),
    Rule("ambiguous", looks_like_untestable),
    Rule("ambiguous", grows_with_another),
    Rule("named", known_by_name),
)
"""The first rule that applies gives the verdict; the last rule always applies."""


def decide(facts: Facts) -> Decision:
    """Return the verdict of a set: the verdict of the first rule that applies."""
    of_set = (rule.judge(facts) for rule in RULES if not rule.of_survey)
    return next((found for found in of_set if found is not None), None) or facts.said


def said_of(case: Case) -> Decision:
    """Return the decision of the survey's rules for one survey."""
    of_survey = (rule.judge(case) for rule in RULES if rule.of_survey)
    return next(found for found in of_survey if found is not None)


def rule_table() -> list[str]:
    """Return the table as lines of Markdown."""
    return ["| | Verdict | When |", "|---|---|---|"] + [
        f"| {number} | `{rule.verdict}` | {rule.says} |" for number, rule in enumerate(RULES, 1)
    ]
