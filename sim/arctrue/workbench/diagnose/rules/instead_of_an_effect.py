"""Rules for an error that jumps, oscillates or repeats itself, or that fits a product of parts or a
refused effect better than the best effect."""

from __future__ import annotations

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.case import Case
from arctrue.workbench.diagnose.classes import adds, without_unspecific
from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.equal_slips import equal_slips
from arctrue.workbench.diagnose.jumps import jumps_in_words, whole_counts
from arctrue.workbench.diagnose.lack_of_fit import LACK_OF_FIT
from arctrue.workbench.diagnose.next_measurement import (
    AT_ANOTHER_SPEED,
    AT_ONE_SPEED,
    CLAMPED_AGAIN,
    LONGER_AND_BACK,
    LOOK_AT_THE_STAND,
    SLOWER_WITH_THE_INDEX,
    WITH_THE_INDEX,
)
from arctrue.workbench.diagnose.posterior import PARTS_ADVANTAGE
from arctrue.workbench.diagnose.rivals import NEAR_TIE
from arctrue.workbench.diagnose.rules.best_effect import LEAST_TAKEN, channels_moved
from arctrue.workbench.diagnose.same_ramp import same_ramp
from arctrue.workbench.diagnose.steps_of_heads import heads_that_step
from arctrue.workbench.diagnose.survey import Survey
from arctrue.workbench.inference.forward.cycles import p_among_cycles
from arctrue.workbench.inference.forward.mountings import describes_mountings
from arctrue.workbench.inference.forward.oscillation import Oscillation
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.places import LINES
from arctrue.workbench.inference.significance import SIGNIFICANCE


def jumped_once(case: Case) -> Decision | None:
    """A jump explains more than any effect or product of parts."""
    steps = case.survey.detections.steps
    step = max(steps, key=lambda item: item.gain, default=None)
    if step is None or (case.best is not None and case.best.regular is not None):
        return None
    rivals = [item.gain for item in (case.best, case.product) if item is not None]
    if any(gain > 2.0 * step.gain - NEAR_TIE for gain in rivals):
        return None
    count_arcsec = case.survey.base.observations.count_arcsec
    look_alikes = {}
    if whole_counts(steps, count_arcsec):
        untestable = case.survey.untestable.items()
        look_alikes = {name: lacking for name, lacking in untestable if case.effects[name].step_at}
    return Decision(
        "unknown",
        seen=jumps_in_words(steps, count_arcsec),
        look_alikes=look_alikes,
        next=LOOK_AT_THE_STAND,
    )


def loses_counts_again(case: Case) -> Decision | None:
    """R₂ − R₁ changes three times or more by the same whole number of counts."""
    if case.depth > 1:
        return None
    found = equal_slips(case.survey.base)
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
    change, best = case.survey.detections.cycles, case.best
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


OF_AN_OSCILLATION = 0.75
"""A line or a product of parts explains an oscillation if it gains more than this share of the
oscillation's gain. A line explains all of a sine whose amplitude or phase changes little. It
explains about a third of an oscillation that loses its phase twenty times in the record and
therefore has the width of six frequencies that the record separates."""


def driven_by_noise(case: Case) -> Decision | None:
    """The noise has a damped oscillation, or a line is in a part of a log or has its own phase in
    each run; lines and products of parts gain less than three quarters as much, other effects less
    than a tenth. A line of a phase in each run replaces the line of one phase at its frequency."""
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
    if best is not None and found.channel not in channels_moved(best, case.survey):
        return None
    most = (OF_AN_OSCILLATION if flexible else LEAST_TAKEN) * 2.0 * found.gain
    if best is not None and best.gain > most and not _has_own_phases(best, found):
        return None
    return Decision("unknown", seen=found.words(), oscillation=found)


def _has_own_phases(line: Candidate, found: Oscillation) -> bool:
    """The oscillation is this line, with a phase for each run."""
    hz = line.nonlinear.get("frequency", 0.0)
    return found.in_each_run is not None and abs(hz - found.hz) < found.hz / found.quality


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
    return survey.detections.oscillation is not None or min(p_values, default=1.0) < LACK_OF_FIT


def runs_change_equally(case: Case) -> Decision | None:
    """No effect is found, and the capture changes evenly and equally within every run, also with
    the best product of parts in the model."""
    if case.best is not None or case.depth > 1:
        return None
    product = case.product
    found = same_ramp(case.survey.residuals if product is None else Residuals(product.solution))
    if found is None or found.rms_arcsec < case.survey.matters_arcsec:
        return None
    measurement = LONGER_AND_BACK if len(found.coordinates) == 1 else AT_ANOTHER_SPEED
    return Decision("unknown", seen=found.words(), next=measurement)


def described_by_parts(case: Case) -> Decision | None:
    """A product of parts leads the whole catalogue by more than ΔBIC 10."""
    if case.product is None or case.ahead <= PARTS_ADVANTAGE:
        return None
    left = case.with_it(case.product) if case.depth == 1 else None
    further = None if left is None else left.decision
    if further is None or further.verdict not in ("named", "ambiguous"):
        return Decision("unknown", described=case.product)
    return Decision("unknown", described=case.product, further=further)


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
    """Other rows contradict the effect that fits best by far, and the next effect adds nothing."""
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
    if refused.effect.step_at is not None:
        why = heads_that_step(case.survey.residuals, refused.nonlinear) or why
    return Decision("unknown", resembles=refused, unlike=why)
