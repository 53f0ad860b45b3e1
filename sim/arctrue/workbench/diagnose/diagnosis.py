"""Which physical effect is missing, or that the data cannot tell, or that none of these fits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from arctrue.percent import probability_percent
from arctrue.progress import Say
from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.classes import without_unspecific
from arctrue.workbench.diagnose.coverage import Coverage, blindness, coverage, effect_or_noise
from arctrue.workbench.diagnose.data_faults import data_faults
from arctrue.workbench.diagnose.decision import (
    DEEPEST,
    NEAR_TIE,
    PARTS_ADVANTAGE,
    Case,
    Decision,
    Verdict,
    decide,
)
from arctrue.workbench.diagnose.every_pass import on_every_pass
from arctrue.workbench.diagnose.heldout import HeldOut
from arctrue.workbench.diagnose.posterior import allowed_for, posterior, verdict_of
from arctrue.workbench.diagnose.probabilities import UNKNOWN
from arctrue.workbench.diagnose.survey import Survey, survey
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.every_row import on_every_row
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.normal_equations import Term
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.search_parameters import refined
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.wrong_rows import without_wrong_rows

MATTERS_COUNTS = 0.5
"""An effect that moves the prediction by less than this many counts RMS is negligible."""
MORE_READINGS_THAN_COEFFICIENTS = (
    "the same stations once more: this set has no more readings than coefficients, so "
    "that nothing tells the noise (or state standard_uncertainty_arcsec)"
)


@dataclass
class Diagnosis:
    """The verdict and what it rests on."""

    observations: Observations
    base: Solution | None
    verdict: Verdict
    named: Candidate | None = None
    effect_class: list[str] = field(default_factory=list)
    class_correlation: dict[str, float] = field(default_factory=dict)
    """Largest canonical correlation of each with the first of the class, beside the model."""
    candidates: list[Candidate] = field(default_factory=list)
    parts: list[Candidate] = field(default_factory=list)
    described: Candidate | None = None
    """The product of parts that explains what no known effect does."""
    description: str | None = None
    next_measurement: str | None = None
    next_measurement_kind: str | None = None
    """Its short name, for programs: one of ``arctrue simulate --further``."""
    noise_arcsec: dict[str, float] = field(default_factory=dict)
    residual_rms_arcsec: dict[str, float] = field(default_factory=dict)
    lack_of_fit: dict[str, float] = field(default_factory=dict)
    held_out_before: HeldOut | None = None
    untestable: dict[str, list[str]] = field(default_factory=dict)
    negligible: list[Candidate] = field(default_factory=list)
    beside: list[Candidate] = field(default_factory=list)
    """Effects that still add something that matters once what was found is in the model."""
    unconfirmed: str | None = None
    """Why an effect that fits, and has no rival, is not named."""
    resembles: Candidate | None = None
    """The effect of the catalogue that an unknown one looks like, and is not."""
    unlike: str | None = None
    """Why it is not that one."""
    faults: list[str] = field(default_factory=list)
    covers: Coverage = field(default_factory=Coverage)
    probability: dict[str, float] = field(default_factory=dict)
    """Of every effect that was tested, ``none`` and ``unknown``; the sum is 1."""
    cannot_tell: str | None = None
    """Why, where the verdict is ``cannot_tell``."""
    excluded: frozenset[str] = frozenset()
    """Effects that fit, and that held-out rows, passes or speeds speak against."""
    look_alikes: dict[str, list[str]] = field(default_factory=dict)
    """Effects that this set cannot test but that would look like the first, with what it lacks."""


def diagnose(
    observations: Observations,
    terms: Sequence[Term],
    effects: Mapping[str, type[Effect]],
    *,
    matters_counts: float = MATTERS_COUNTS,
    progress: Say = lambda text: None,
) -> Diagnosis:
    """Judge every effect that ``terms`` lacks; nothing is drawn: same inputs, same result."""
    faults = data_faults(observations)
    if faults:
        return Diagnosis(
            observations,
            None,
            "bad_data",
            faults=faults,
            next_measurement="record the faulty runs again",
            probability=_probability_of_nothing(),
        )
    progress("fitting the model")
    base = fit(terms, observations)
    residuals = Residuals(base)
    if _noise_is_unknown(base):
        return Diagnosis(
            observations,
            base,
            "cannot_tell",
            next_measurement=MORE_READINGS_THAN_COEFFICIENTS,
            cannot_tell="its rows are too few beside the coefficients to show noise",
            probability=_probability_of_nothing(),
        )
    count = observations.count_arcsec
    matters = 0.0 if count is None else matters_counts * count
    tried = survey(residuals, effects, matters, progress)

    def with_first(first: Candidate) -> Survey:
        progress(f"once more beside {first.name}")
        left = Residuals(first.at_maximum)
        return survey(
            left, effects, matters, lambda text: None, negligible=False, looks=DEEPEST - 1
        )

    found = decide(Case(tried, effects, with_first))
    if found.verdict not in ("adequate", "cannot_tell"):
        left_arcsec = _deepest(found, base).capture_residual_arcsec()
        without = without_wrong_rows(observations, left_arcsec)
        if without is not None:
            progress("once more without single wrong rows")
            return diagnose(
                replace(without, may_mask=False),
                terms,
                effects,
                matters_counts=matters_counts,
                progress=progress,
            )
    result = _told(observations, tried, found)
    result.covers = coverage(residuals, result.candidates, result.untestable, tried.absent)
    if result.verdict == "adequate":
        _unless_blind(result, residuals, matters, tried.absent)
    _agree(result)
    progress("fitting every row")
    _sharpen(result)
    return result


def _deepest(found: Decision, base: Solution) -> Solution:
    """The solution with most of what is spoken of: it leaves what no effect explains.

    A defect of a few rows is not taken off: it may be a wrong row, and on every turn it is none.
    """
    further: Decision | None = found
    while further is not None:
        first = further.first or further.resembles
        if first is not None and first.effect.local_on_disc:
            break
        base = base if first is None else first.solution
        further = further.beside
    return base


def _told(observations: Observations, tried: Survey, found: Decision) -> Diagnosis:
    """The decision with the survey that it was taken on."""
    candidates = tried.candidates
    first = found.first or found.resembles
    if first is not None:
        # The one that is spoken of stands first, whatever negligible ones fit as well.
        candidates = [first, *(item for item in candidates if item is not first)]
    significant = tried.significant()
    small = [
        item for item in significant if not tried.matters(item) and on_every_pass(item, tried.base)
    ]
    real = Case(tried, {}, lambda item: tried).at_every_speed
    kept = {item.name for item in (*real, *small)}
    negligible = without_unspecific(small)
    if found.resembles is not None:
        kept.discard(found.resembles.name)
    described = found.described
    return Diagnosis(
        observations,
        tried.base,
        found.verdict,
        named=found.first if found.verdict == "named" else None,
        effect_class=found.effect_class,
        class_correlation=found.class_correlation,
        candidates=candidates,
        parts=tried.parts,
        described=described,
        description=None
        if described is None
        else described.effect.describe(described.parameters()),
        next_measurement=None if found.next is None else found.next.words,
        next_measurement_kind=None if found.next is None else found.next.kind,
        noise_arcsec=tried.noise_arcsec,
        residual_rms_arcsec=tried.residual_rms_arcsec,
        lack_of_fit=tried.lack_of_fit,
        held_out_before=tried.held_out_before,
        untestable=tried.untestable,
        negligible=negligible,
        beside=_beside(found),
        unconfirmed=found.unconfirmed,
        resembles=found.resembles,
        unlike=found.unlike,
        excluded=frozenset(item.name for item in significant if item.name not in kept),
        look_alikes=found.look_alikes,
    )


def _beside(found: Decision) -> list[Candidate]:
    """What would be named, one after the other, with the first in the model."""
    names: list[Candidate] = []
    further = found.beside if found.verdict == "named" else None
    while further is not None and further.verdict == "named" and further.first is not None:
        names.append(further.first)
        further = further.beside
    return names


def _unless_blind(
    result: Diagnosis, residuals: Residuals, matters_arcsec: float, tests: int
) -> None:
    """Nothing was found; where little could be, that says nothing."""
    found = blindness(
        residuals, result.covers, result.residual_rms_arcsec, matters_arcsec
    ) or effect_or_noise(result.candidates, tests, matters_arcsec)
    if found is not None:
        result.verdict = "cannot_tell"
        result.cannot_tell = found.reason
        result.next_measurement = found.next_measurement
        result.next_measurement_kind = found.next_measurement_kind


def _probability_of_nothing() -> dict[str, float]:
    """Beforehand: nothing was tested."""
    return posterior(
        "cannot_tell",
        [],
        1,
        effect_class=[],
        look_alikes=[],
        product=None,
        excluded=frozenset(),
        lack_of_fit_p=1.0,
        near_tie=NEAR_TIE,
        advantage=PARTS_ADVANTAGE,
    )


def _probability(result: Diagnosis) -> dict[str, float]:
    product = result.described
    if product is None and not result.effect_class:
        product = next(iter(result.parts), None)
    return posterior(
        result.verdict,
        result.candidates,
        len(result.untestable),
        effect_class=result.effect_class,
        look_alikes=list(result.look_alikes),
        product=product,
        excluded=result.excluded,
        lack_of_fit_p=min(result.lack_of_fit.values(), default=1.0),
        near_tie=NEAR_TIE,
        advantage=PARTS_ADVANTAGE,
    )


def _agree(result: Diagnosis) -> None:
    """The probabilities, and the verdict that they ask for where the rules leave it open."""
    found = _probability(result)
    offered = allowed_for(found, result.verdict, result.candidates)
    verdict = verdict_of(result.verdict, result.effect_class, offered)
    if verdict == "unknown" != result.verdict:
        if result.described is None:
            # What fits best of what was refused, or else the first of the class.
            refused = [item for item in result.candidates if item.name in result.excluded]
            likely = refused or result.candidates[:1]
            result.resembles = max(likely, key=lambda item: item.delta_bic)
            share = probability_percent(offered[UNKNOWN])
            result.unlike = f"what is in no catalogue is more probable than any effect, {share}"
        result.effect_class, result.class_correlation, result.look_alikes = [], {}, {}
        result.unconfirmed = None
    elif verdict == "ambiguous" != result.verdict:
        share = probability_percent(offered[result.effect_class[0]])
        result.unconfirmed = f"it has {share} of the probability, which is too little for a name"
    if verdict != result.verdict:
        result.verdict, result.named, result.beside = verdict, None, []
    result.probability = allowed_for(found, verdict, result.candidates)


def _noise_is_unknown(base: Solution) -> bool:
    """No channel has readings beyond what its coefficients take, nor a stated uncertainty."""
    observations = base.observations
    there = {
        name
        for name, rows in (("capture", observations.capture), ("reference", observations.reference))
        if rows is not None
    }
    return there <= base.unknown_noise


def _sharpen(result: Diagnosis) -> None:
    """What the verdict rests on: search parameters refined, and fitted to every row."""
    chosen = [] if result.described is None else [result.described]
    if result.effect_class:
        chosen.append(result.candidates[0])
    for item in chosen:
        item.solution = on_every_row(refined(item.solution))
        item.nonlinear = item.solution.terms[-1].nonlinear
