"""Names the physical effect that a model lacks; otherwise states that the data cannot show it, or
that no known effect fits.

A diagnosis goes through stages, and each gives a frozen record to the next: faults of the data →
candidates → evidence → probabilities → rules → next measurement.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from arctrue.base.progress import ReportStep
from arctrue.workbench.diagnose.adding import Adding
from arctrue.workbench.diagnose.candidate import Candidate, is_line, within_the_record
from arctrue.workbench.diagnose.case import DEEPEST, Case
from arctrue.workbench.diagnose.coverage import Coverage, coverage
from arctrue.workbench.diagnose.data_faults import data_faults, too_short
from arctrue.workbench.diagnose.decision import Decision, Verdict
from arctrue.workbench.diagnose.detections import Detections
from arctrue.workbench.diagnose.equal_descriptions import (
    also_to_separate,
    equal_descriptions,
    to_separate,
)
from arctrue.workbench.diagnose.evidence import described_above, survey
from arctrue.workbench.diagnose.facts import Facts
from arctrue.workbench.diagnose.grounds import Grounds
from arctrue.workbench.diagnose.lack_of_fit import LEAST_EXCESS
from arctrue.workbench.diagnose.lag import Lag, lag_of
from arctrue.workbench.diagnose.next_measurement import NextMeasurement, measurement_for
from arctrue.workbench.diagnose.of_the_runs import (
    DirectionDifference,
    IndexScatter,
    direction_difference,
    index_beyond_its_prior,
)
from arctrue.workbench.diagnose.posterior import PARTS_ADVANTAGE
from arctrue.workbench.diagnose.regular import detections_of
from arctrue.workbench.diagnose.remaining_error import RemainingError, remaining_error
from arctrue.workbench.diagnose.rivals import NEAR_TIE, REFUSED_P
from arctrue.workbench.diagnose.rules.table import decide, said_of
from arctrue.workbench.diagnose.signal_period import SignalPeriod, signal_period
from arctrue.workbench.diagnose.slopes_of_passes import SlopesOfPasses, slopes_of_passes
from arctrue.workbench.diagnose.survey import FitOfChannel, Survey
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.detectable import Refused
from arctrue.workbench.inference.every_row import on_every_row
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.forward.oscillation import Oscillation
from arctrue.workbench.inference.left import Left
from arctrue.workbench.inference.place_among_orders import place_among_orders
from arctrue.workbench.inference.repeated_error import RepeatedError
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.search_parameters import refined
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.inference.visits_of_places import visits_of
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.one_speed import coordinate, passes_of
from arctrue.workbench.observations.wrong_rows import without_wrong_rows

MATTERS_COUNTS = 0.5
"""Smallest size of an effect that is not negligible, as the RMS change of the prediction, in
counts."""


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The verdict and the results on which it rests."""

    observations: Observations
    base: Solution | None
    decision: Decision
    probability: Mapping[str, float]
    """Probability of every tested effect, of ``none`` and of ``unknown``; the sum is 1."""
    measurement: NextMeasurement | None
    """The next measurement to make."""
    candidates: Sequence[Candidate] = ()
    """Candidates, first the candidate that the decision states, then the others, best first."""
    negligible: Sequence[Candidate] = ()
    untestable: Mapping[str, list[str]] = field(default_factory=dict)
    """Data that the set lacks, for each effect that it cannot test."""
    channels: Mapping[str, FitOfChannel] = field(default_factory=dict)
    """Fit of the model to each channel, with its lack of fit."""
    before: Left | None = None
    """Residual of the model."""
    left: Mapping[str, Left] = field(default_factory=dict)
    """Residual of the model with the stated effect, and with each other effect of its class, by the
    name of the effect."""
    unlike: tuple[str, ...] = ()
    """Ways in which the set differs from the sets on which the probabilities were calibrated."""
    grounds: Grounds | None = None
    """Numbers on which the stated probability rests; None where nothing was tested."""
    second: RemainingError | None = None
    """The error that remains with the named effect in the model, if that error is significant."""
    lag: Lag | None = None
    """The lag of the condition that describes the error, if this lag explains most of the error
    that remains with the description."""
    signal_period: SignalPeriod | None = None
    """The signal period, if the named line is a multiple of it."""
    covers: Coverage = field(default_factory=Coverage)
    instead: Candidate | None = None
    """Effect that the rules name if they set the refused effect aside; only :func:`diagnose` with
    ``instead`` looks for it."""
    index_scatter: IndexScatter | None = None
    """Scatter of the runs' offsets beyond the known index, if nothing was found."""
    directions: DirectionDifference | None = None
    """Difference of the runs' offsets between the directions, if nothing was found."""
    equals: Sequence[Candidate] = ()
    """The products with another condition that describe the error as well as
    :attr:`described`."""
    slopes: SlopesOfPasses | None = None
    """Slopes over the angle by which the passes over an arc differ, if nothing was found."""
    detections: Detections = field(default_factory=Detections)
    """Detections in the reference; if an effect is named or described, the detections that remain
    with it.
    """

    @property
    def verdict(self) -> Verdict:
        """The verdict on the model."""
        return self.decision.verdict

    @property
    def named(self) -> Candidate | None:
        """The missing effect, if the verdict names one."""
        return self.decision.first if self.verdict == "named" else None

    @property
    def effect_class(self) -> list[str]:
        """The first effect, and every effect that this data cannot distinguish from it."""
        return list(self.decision.effect_class)

    @property
    def described(self) -> Candidate | None:
        """The product of parts that explains the error if no known effect does; with the verdict
        ``ambiguous``, a product that explains it as well as the first effect."""
        return self.decision.described

    @property
    def description(self) -> str | None:
        """Description of the product of parts in :attr:`described`, with its fitted size."""
        found = self.described
        return None if found is None else found.effect.describe(within_the_record(found))

    @property
    def next_measurement(self) -> str | None:
        """The next measurement in words, for people."""
        return None if self.measurement is None else self.measurement.words

    @property
    def next_measurement_kind(self) -> str | None:
        """The short name of the next measurement, for programs: a choice of ``arctrue capture
        --next``."""
        return None if self.measurement is None else self.measurement.kind

    @property
    def further(self) -> list[Candidate]:
        """Effects that the diagnosis would name next, one after another, with the first effect in
        the model."""
        names: list[Candidate] = []
        further = self.decision.further if self.verdict == "named" else None
        while further is not None and further.verdict == "named" and further.first is not None:
            names.append(further.first)
            further = further.further
        return names


def diagnose(
    observations: Observations,
    terms: Sequence[Term],
    effects: Mapping[str, type[Effect]],
    *,
    matters_counts: float = MATTERS_COUNTS,
    report_step: ReportStep = lambda text: None,
    instead: bool = False,
    given: Adding | None = None,
) -> Diagnosis:
    """Test every effect that ``terms`` lacks. Nothing is random, so equal inputs give equal
    results.

    ``instead``: whether to apply the rules again, without the effect that they refused.
    ``given``: an Adding whose base is the model fitted to the rows that a command uses. It is given
    if single wrong rows have been left out of ``observations``.
    """
    faults = data_faults(observations)
    if faults:
        return _stated(observations, None, Facts(faults))
    short = too_short(observations)
    if short is not None:
        return _stated(observations, None, Facts(too_short=short))
    report_step("fitting the model")
    base = fit(terms, observations)
    if base.noise_is_unknown:
        return _stated(observations, base, Facts())
    adding = given or Adding(Residuals(base), effects)
    report_step("looking for regular lines")
    detections = detections_of(base, effects)
    case = _case_of(base, adding, detections, matters_counts, report_step)
    if case.decision.verdict != "adequate":
        left_arcsec = _deepest(case.decision, base).capture_residual_arcsec()
        without = without_wrong_rows(observations, left_arcsec)
        if without is not None:
            report_step("fitting again without single wrong rows")
            return diagnose(
                replace(without, may_mask=False),
                terms,
                effects,
                matters_counts=matters_counts,
                report_step=report_step,
                instead=instead,
                given=adding,
            )
    tried = case.survey
    refused = Refused(REFUSED_P, PARTS_ADVANTAGE)
    covers = coverage(
        tried.residuals, case.ranked, tried.untestable, tried.absent, tried.tested, refused
    )
    facts = Facts(case=case, covers=covers)
    report_step("fitting every row")
    found = _described_above(_stated(observations, base, facts), tried, report_step)
    report_step("adding the effect to the model")
    names = {item.name for item in (found.decision.spoken_of,) if item is not None}
    after = {name: adding.after(name) for name in [*names, *found.effect_class]}
    left = {name: item for name, item in after.items() if item is not None}
    second = _second(found.decision, left) if found.verdict == "named" else None
    period = signal_period(found.named, tried.untestable, effects)
    detections = _with_the_found(detections, found, case, effects)
    if case.best is not None and found.decision.first is not None:
        detections = detections.with_other(case.best.regular, found.decision.first.regular)
    detections = _once(
        detections, found.decision.oscillation or detections.oscillation, observations
    )
    if found.detections.places is not None:
        detections = replace(detections, places=found.detections.places)
    lag = lag_of(found.described, base) if found.verdict == "unknown" else None
    if lag is not None or found.slopes is not None:
        detections = replace(detections, slow=None)
    return replace(
        found,
        lag=lag,
        before=adding.before,
        left=left,
        second=second,
        signal_period=period,
        measurement=found.measurement or (None if period is None else period.measurement),
        instead=case.instead if instead else None,
        detections=detections,
    )


def _described_above(found: Diagnosis, tried: Survey, report_step: ReportStep) -> Diagnosis:
    """Return the diagnosis with a description of the unknown error, if this error is a line of a
    high order. The verdict, which rests on the catalogue, does not change."""
    said = found.decision
    if said.verdict != "unknown" or said.described is not None or said.seen is not None:
        return found
    report_step("looking for lines of a high order")
    item = described_above(tried, report_step)
    if item is None:
        return found
    item = _sharpened(item)
    measurement = found.measurement or measurement_for(None, item)
    return replace(found, decision=replace(said, described=item), measurement=measurement)


def _with_the_found(
    detections: Detections, found: Diagnosis, case: Case, effects: Mapping[str, type[Effect]]
) -> Detections:
    """Return the detections that remain with the named effect in the model.

    The named effect may appear in the reference as a line at an alias, an oscillation or a step;
    these are no further detections. If the effect is a regular cause, its own lines stay in the
    list, and only the oscillation is searched again. A part of the effect, such as a phase that
    depends on the direction, may have looked like a resonance. If a product of parts describes the
    whole error, the lines and the jumps are searched again: an error that follows the speed differs
    from run to run and may have looked like a jump, or like a line on each side of its own order. A
    friction that follows a load may have looked like a mirror that moves between the cycles. A slow
    change that the product describes has a known form; if the product leaves a slow change,
    the size of the whole change is stated.
    """
    item, product = found.named, found.described
    if product is not None and found.verdict == "unknown":
        lists = detections.steps or detections.causes
        within = detections.cycles is not None and not detections.cycles.of_runs
        cycles = detections.cycles if within else None
        others = (detections.places, detections.slow, cycles, detections.oscillation)
        if not lists and all(item is None for item in others):
            return detections
        left = detections_of(product.at_maximum, effects)
        if left.slow is None:
            detections = replace(detections, slow=None)
        if found.decision.resembles is not None:
            return detections
        return replace(
            detections,
            causes=left.causes if detections.causes else (),
            oscillation=left.oscillation if detections.oscillation is not None else None,
            steps=left.steps if detections.steps else (),
            places=left.places,
            cycles=left.cycles if within else detections.cycles,
            fast=left.fast if detections.fast else (),
            drift=left.drift if detections.drift is not None else None,
        )
    first = found.decision.first
    if first is not None and found.verdict == "ambiguous" and case.with_best is not None:
        # With passes in one direction, an even drift is the same ramp over the angle in each pass.
        return replace(detections, places=case.with_best.survey.detections.places)
    if item is None or detections.empty or case.with_best is None:
        return detections
    if item.regular is not None and detections.places is not None:
        detections = replace(detections, places=case.with_best.survey.detections.places)
    if item.regular is None:
        left = detections.further(
            item.name, case.with_best.survey.detections, is_line=is_line(item)
        )
        if item.second_of_runs is None or detections.cycles is None:
            return left
        both = (item.name, item.second_of_runs.words)
        return replace(left, cycles=replace(detections.cycles, explained_by=both))
    if detections.oscillation is None:
        return detections
    return replace(detections, oscillation=detections_of(item.at_maximum, effects).oscillation)


def _once(
    detections: Detections, seen: Oscillation | None, observations: Observations
) -> Detections:
    """Return the detections without the fast lines that are the oscillation ``seen`` in one of the
    runs."""
    rows = observations.reference
    if seen is None or seen.in_each_run is None or rows is None or rows.time_s is None:
        return detections
    turns = coordinate(rows, in_time=False)
    if turns is None:
        return detections
    passes = [(speed, length) for speed, length, _ in passes_of(turns, rows.time_s, rows.run)]
    return detections.without_fast(seen.hz, passes)


def _second(found: Decision, left: Mapping[str, Left]) -> RemainingError | None:
    """Return the error that remains with the named effect in the model; None if it is not
    significant or if a further effect would be named."""
    assert found.first is not None
    further = found.further
    if found.first.name not in left or (further is not None and further.verdict == "named"):
        # The further effect is stated in place of the error.
        return None
    after = left[found.first.name]
    product = None if further is None else further.described
    words = None if product is None else product.effect.describe(within_the_record(product))
    # An ambiguous further effect is not stated either.
    unknown = further is not None and further.verdict in ("unknown", "ambiguous")
    if unknown and further is not None and product is None and further.seen is None:
        # A remainder of unknown form that is not much larger than the noise counts as noise; the
        # JSON contains the tests of the noise.
        unknown = any(
            rms**2 > (1.0 + LEAST_EXCESS**2) * after.noise_arcsec[channel] ** 2
            for channel, rms in after.rms_arcsec.items()
        )
    return remaining_error(after, unknown=unknown, description=words)


def _case_of(
    base: Solution,
    adding: Adding,
    detections: Detections,
    matters_counts: float,
    report_step: ReportStep,
) -> Case:
    """Collect the candidates with their evidence, and the further data that the rules need."""
    effects = adding.effects
    if adding.base is not base:
        # This fit excludes single wrong rows, because they would hide the error that an effect
        # explains.
        adding = Adding(Residuals(base), effects)
    count = base.observations.count_arcsec
    matters = 0.0 if count is None else matters_counts * count

    def with_first(before: Survey, first: Candidate) -> Survey:
        report_step(f"diagnosing again with {first.name} in the model")
        solution = first.at_maximum
        if first.second_of_runs is not None:
            # The solution of this effect is for rows from which the other effect is subtracted.
            solution = fit(solution.terms, before.base.observations)
        left = before.detections.without(first.regular)
        if left.places is not None and first.regular is not None:
            visits = visits_of(first.at_maximum)
            left = replace(left, places=None if visits is None else visits.repeated())
        if first.regular is None and not left.empty:
            left = detections_of(solution, effects)
        return survey(
            Residuals(solution),
            effects,
            matters,
            lambda text: None,
            negligible=False,
            looks=DEEPEST - 1,
            detections=left if first.effect.step_at is None else left.without_steps(),
        )

    tried = survey(adding.residuals, effects, matters, report_step, detections=detections)
    return Case(tried, effects, with_first, said_of, adding=adding)


def _deepest(found: Decision, base: Solution) -> Solution:
    """Return the solution of the decision that has the most stated effects in its model.

    An effect at one place of the disc is not included: a defect of a few rows may be a wrong row.
    Only a defect that every turn shows is certainly an effect.
    """
    further: Decision | None = found
    while further is not None:
        first = further.spoken_of
        if first is not None and first.effect.local_on_disc:
            break
        base = base if first is None else first.solution
        further = further.further
    return base


def _stated(observations: Observations, base: Solution | None, facts: Facts) -> Diagnosis:
    """State the verdict of the rules with its probabilities and the next measurement."""
    found = decide(facts)
    case, probability = facts.case, facts.probability(found)
    scatter: IndexScatter | None = None
    if case is not None and found.verdict in ("adequate", "cannot_tell"):
        scatter = index_beyond_its_prior(case.survey.residuals)
        if scatter is not None and scatter.rms_arcsec < case.survey.matters_arcsec:
            scatter = None
    directions: DirectionDifference | None = None
    if case is not None and found.verdict in ("adequate", "cannot_tell"):
        directions = direction_difference(case.survey.residuals)
        if directions is not None and directions.size_arcsec < case.survey.matters_arcsec:
            directions = None
    slopes: SlopesOfPasses | None = None
    nothing = found.verdict in ("adequate", "cannot_tell") or found.rests_on == "undescribed"
    if case is not None and nothing:
        slopes = slopes_of_passes(case.survey.base)
        if slopes is not None and abs(slopes.size_arcsec) < case.survey.matters_arcsec:
            slopes = None
    place: RepeatedError | None = None
    if case is not None and nothing and case.survey.detections.places is None:
        place = place_among_orders(case.survey.base)
        if place is not None and place.largest_arcsec < case.survey.matters_arcsec:
            place = None
    if any(item is not None for item in (scatter, directions, slopes, place)):
        probability = _less_of_none(probability)
    measurement = found.next or measurement_for(found.question, found.described)
    if slopes is not None:
        measurement = NextMeasurement(slopes.next_measurement(), None)
    if case is None:
        return Diagnosis(observations, base, found, probability, measurement)
    candidates, equals = case.ranked, _equals(found, case)
    if found.described is not None and equals:
        if found.verdict == "ambiguous":
            measurement = also_to_separate(measurement, found.described, equals)
        else:
            measurement = to_separate(found.described, equals)
    if found.described is not None:
        found = replace(found, described=_sharpened(found.described))
    if found.a_part and found.resembles is not None and found.described is not None:
        # Both parts are in the model of the description, so that neither counts as noise.
        part = replace(found.resembles, with_further=found.described.solution)
        candidates = [part, *(item for item in candidates if item is not found.resembles)]
        found = replace(found, resembles=part)
    if found.effect_class:
        first = _as_fitted(replace(_sharpened(candidates[0]), with_further=_with_further(found)))
        candidates = [first, *candidates[1:]]
        found = replace(found, first=candidates[0])
    return Diagnosis(
        observations,
        base,
        found,
        probability,
        measurement,
        candidates,
        case.negligible,
        case.survey.untestable,
        case.survey.channels,
        covers=facts.covers,
        unlike=facts.unlike,
        grounds=facts.grounds(found),
        index_scatter=scatter,
        directions=directions,
        equals=equals,
        slopes=slopes,
        detections=Detections(places=place),
    )


def _equals(found: Decision, case: Case) -> list[Candidate]:
    """Return the products with another condition that describe the error as well as the described
    product, without those that are an effect of the class."""
    if found.described is None or found.verdict not in ("unknown", "ambiguous"):
        return []
    named = [set(item.effect.in_parts) for item in case.ranked if item.name in found.effect_class]
    equals = equal_descriptions(found.described, case.survey.residuals, NEAR_TIE)
    return [item for item in equals if set(item.effect.parts) not in named]


def _with_further(found: Decision) -> Solution | None:
    """Return the model with the named effect and the effects that are found after it, up to the
    first from whose rows another effect was subtracted; None without such effects."""
    if found.verdict != "named" or found.first is None or found.first.second_of_runs is not None:
        return None
    last: Candidate | None = None
    further = found.further
    while further is not None and further.first is not None:
        if further.first.second_of_runs is not None:
            break
        last, further = further.first, further.further
    return None if last is None else on_every_row(last.at_maximum)


def _as_fitted(item: Candidate) -> Candidate:
    """Return the candidate with the search parameters, and the regular cause, of the model that
    also has the further effects, so that all sentences state the same values."""
    if item.with_further is not None:
        place = len(item.solution.terms) - 1
        item = replace(item, nonlinear=item.with_further.terms[place].nonlinear)
    if item.regular is None:
        return item
    amplitude = item.parameters().get("amplitude")
    size = None if amplitude is None else amplitude.value
    return replace(item, regular=item.regular.fitted(item.nonlinear, size))


MOST_OF_NONE = 0.5
"""Largest probability of ``none``, its prior, if the runs' offsets scatter beyond the known index
or differ between the directions, if passes differ by a slope, or if a single station is off among
many orders: no answer of the calibration had such detections."""


def _less_of_none(probability: Mapping[str, float]) -> dict[str, float]:
    """Return the probabilities with at most MOST_OF_NONE for ``none``; the difference is added to
    ``unknown``."""
    found = dict(probability)
    moved = max(found.get("none", 0.0) - MOST_OF_NONE, 0.0)
    found["none"] = found.get("none", 0.0) - moved
    found["unknown"] = found.get("unknown", 0.0) + moved
    return found


def _sharpened(item: Candidate) -> Candidate:
    """Return the candidate of a verdict with refined search parameters, fitted to every row."""
    solution = on_every_row(refined(item.solution))
    return replace(item, solution=solution, nonlinear=solution.terms[-1].nonlinear)
