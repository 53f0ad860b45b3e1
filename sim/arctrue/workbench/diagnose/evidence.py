"""Collects the evidence for effects that may be named: likelihood ratios, and held-out rows.

For the likelihood ratios the noise is estimated anew both without and with the effect. This is the
second stage of a diagnosis: :func:`survey` tests every candidate (:mod:`candidates`), estimates the
noise anew for candidates that may be named, and gives one frozen record to the rules.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from arctrue.base.progress import ReportStep
from arctrue.workbench.diagnose.candidate import Candidate, SecondRunEffect, delta_bic
from arctrue.workbench.diagnose.candidates import (
    regular_candidates,
    tried_above,
    tried_effects,
    tried_forms,
    tried_products,
    with_regular,
)
from arctrue.workbench.diagnose.condition_forms import is_searched_form
from arctrue.workbench.diagnose.detections import Detections
from arctrue.workbench.diagnose.every_pass import at_other_speeds
from arctrue.workbench.diagnose.evidence_of_one import (
    AS_GOOD,
    with_evidence,
    with_gain_of,
    with_noise_of_another,
)
from arctrue.workbench.diagnose.of_the_runs import leaves_the_index
from arctrue.workbench.diagnose.second_head_effect import second_head_effects
from arctrue.workbench.diagnose.second_run_effect import second_run_effects, without
from arctrue.workbench.diagnose.survey import Survey, fit_of_channels, takes_most
from arctrue.workbench.diagnose.with_a_real_effect import (
    FAR_BEHIND,
    best_with,
    bic_with,
    may_come_before,
    same_columns,
    with_noise_of,
)
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.registry import absent_effects
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.forward.of_solution import without_steps
from arctrue.workbench.inference.likelihood_ratio import (
    Null,
    with_index_as_known,
    without_slow_noise,
)
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE, corrected_p_value, single_p_value

NEAR_P = 0.3
"""An effect whose p in the first test is below this value may be named; the noise is therefore
estimated anew with this effect in the model."""
OF_ITS_SIZE = 0.2
"""Largest p, in the first test, of an effect that slow noise may have absorbed. Noise that has
absorbed an effect is about as large as the effect, so that the effect is not far below its standard
uncertainty. An effect that does not exist passes this limit with at most this probability."""
MOST_WEIGHED = 6
"""Largest number of candidates of the catalogue for which the noise is estimated anew."""


def survey(
    residuals: Residuals,
    effects: Mapping[str, type[Effect]],
    matters_arcsec: float,
    report_step: ReportStep,
    *,
    negligible: bool = True,
    looks: int = 1,
    detections: Detections | None = None,
) -> Survey:
    """Test every effect and every product of parts with the model of ``residuals``.

    Without ``negligible``, effects that are far too small to matter get no noise estimate of their
    own, because no verdict depends on them. An effect with a search is tested again even if the
    model has it, because it may exist a second time with other search parameters. ``looks``: number
    of such surveys that the diagnosis makes. ``detections``: results of a forward search with this
    model; they replace the search for an effect of the same name.
    """
    present = {term.effect.name for term in residuals.solution.terms}
    absent = absent_effects(effects, present, residuals.observations)
    repeatable = {
        name: effect for name, effect in effects.items() if name in present and effect.search
    }
    channels = fit_of_channels(residuals)
    asked = absent | repeatable
    candidates, untestable = tried_effects(residuals, asked, len(absent) * looks, report_step)
    found = Detections() if detections is None else detections
    lines = regular_candidates(_beyond_steps(residuals, found), found.causes, len(absent) * looks)
    candidates = with_regular(candidates, lines, found)
    report_step("trying products of parts")
    tried = Survey(
        residuals,
        matters_arcsec,
        len(absent),
        looks,
        candidates,
        tried_products(residuals, looks),
        untestable,
        channels,
        found,
        len(asked) - len(untestable),
    )
    return weighed(tried, report_step, negligible=negligible)


def weighed(tried: Survey, report_step: ReportStep, *, negligible: bool) -> Survey:
    """Return the survey with evidence, from newly estimated noise, for candidates that may be
    named.

    The real effect is the best candidate that is significant, is confirmed, and appears at every
    speed. The noise is estimated anew for one candidate of the catalogue after another: first for
    the lines of a forward search, then for the others in the order of their ΔBIC. The estimates end
    after MOST_WEIGHED candidates, or when no further candidate can be ahead of the real effect. The
    first product of parts, and the best form of a recorded condition with this condition, get
    evidence too if they can be ahead of the real effect.
    """
    null = Null(tried.residuals)
    beyond = replace(tried, residuals=_beyond_steps(tried.residuals, tried.detections))
    null_of_lines = null if beyond.residuals is tried.residuals else Null(beyond.residuals)
    waiting = _near_to_a_name(tried)
    products = tried.parts[:1]
    forms = [
        item
        for item in tried_forms(tried.residuals, tried.looks)
        if all(item.effect.settings != other.effect.settings for other in products)
    ]
    if not negligible:
        waiting = [item for item in waiting if tried.may_matter(item)]
        products = [item for item in products if tried.may_matter(item)]
        forms = [item for item in forms if tried.may_matter(item)]
    together = _second_run_effects(tried)
    named = {item.name for item in waiting}
    waiting += [item for item in tried.candidates if item.name in together.keys() - named]
    judged: dict[str, Candidate] = {}
    real: Candidate | None = None
    for _ in range(MOST_WEIGHED):
        if real is not None:
            waiting = may_come_before(waiting, real)
        if not waiting:
            break
        item = waiting.pop(0)
        if item.name in together:
            item = _judged_with_second(item, together[item.name], tried, report_step)
        elif item.regular is not None:
            item = _largest_sure(item, beyond, null_of_lines, report_step)
        else:
            item = with_evidence(item, tried, null, tried.absent, report_step)
        judged[item.name] = item
        if (
            item.p_corrected < SIGNIFICANCE
            and tried.confirmed(item)
            and at_other_speeds(item)
            and (real is None or item.delta_bic > real.delta_bic)
        ):
            real = item
            waiting = best_with(waiting, real)
    if real is not None and real.second_of_runs is None:
        first = real
        judged = {
            name: with_noise_of_another(item, first, tried, null, tried.absent, report_step)
            for name, item in judged.items()
        }
    parts = [
        *(_judged_product(item, real, tried, null, report_step) for item in products),
        *tried.parts[len(products) :],
    ]
    parts = _with_forms(
        parts,
        [_judged_product(item, real, tried, null, report_step) for item in forms],
        tried,
    )
    candidates = [judged.get(item.name, item) for item in tried.candidates]
    if real is not None:
        anew = with_noise_of([*candidates, *parts], real)
        candidates, parts = anew[: len(candidates)], anew[len(candidates) :]
    candidates.sort(key=lambda item: (-item.delta_bic, item.p_corrected))
    return replace(tried, candidates=candidates, parts=parts)


def described_above(tried: Survey, report_step: ReportStep) -> Candidate | None:
    """Return a product of parts with a line of the capture above the orders of the survey's
    products, if it passes their tests; otherwise None."""
    found = next(iter(tried_above(tried.residuals, tried.looks)), None)
    if found is None:
        return None
    item = with_evidence(found, tried, Null(tried.residuals), 1, report_step)
    return item if item.p_corrected < SIGNIFICANCE and tried.confirmed(item) else None


def _near_to_a_name(tried: Survey) -> list[Candidate]:
    """Return the effects for which the noise is estimated anew: lines of a forward search, then
    others, best first."""
    ranked = sorted(tried.candidates, key=lambda item: -item.delta_bic)
    near = {
        item.name
        for item in ranked
        if item.p_corrected < NEAR_P or item.effect.step_at or takes_most(item.solution, tried.base)
    }
    others = [item for item in ranked if item.name not in near]
    near |= {item.name for item in taken_by_noise(others, tried)}
    near |= {item.name for item in ranked if item.regular is not None}
    # Noise that was estimated without a line may have absorbed the line. Every line of a forward
    # search therefore stays in the list, before all other effects.
    return sorted(
        (item for item in ranked if item.name in near), key=lambda item: item.regular is None
    )


def taken_by_noise(items: Sequence[Candidate], tried: Survey) -> list[Candidate]:
    """Return the effects among ``items`` that would be significant without slow noise.

    This test also disregards offsets of the runs beyond the index repeatability, if the effect
    explains them: a head that drifts in one warm run causes such offsets. Every estimate contains
    at least the noise of this test. An effect that is not significant in this test is therefore not
    significant with any estimate. An effect with a search is left out, because its search
    parameters were fitted to the slow noise.
    """
    fixed = [
        item
        for item in items
        if not item.effect.search and single_p_value(item.gain, item.rank, np.inf) < OF_ITS_SIZE
    ]
    if not fixed:
        return []
    found = _seen_with(without_slow_noise(tried.residuals), fixed, tried)
    if tried.residuals.observations.runs:
        known = without_slow_noise(with_index_as_known(tried.residuals))
        found += [
            item
            for item in _seen_with(known, fixed, tried)
            if item not in found and leaves_the_index(known, item.effect, item.nonlinear)
        ]
    return found


def _seen_with(white: Residuals, items: Sequence[Candidate], tried: Survey) -> list[Candidate]:
    """Return the effects among ``items`` that are significant with the noise of ``white``."""
    scores = white.scores([(item.effect, item.nonlinear) for item in items])
    tests = tried.absent * tried.looks
    return [
        item
        for item, score in zip(items, scores, strict=True)
        if corrected_p_value(score.gain, score.rank, item.trials, tests) < SIGNIFICANCE
    ]


def _second_run_effects(tried: Survey) -> dict[str, SecondRunEffect]:
    """Return the effects that explain the offsets of the runs only together with another effect."""
    tests = tried.absent * tried.looks
    found = second_head_effects(tried.residuals, tried.candidates, tests)
    change = tried.detections.cycles
    if change is not None and not change.order_1_arcsec:
        found |= second_run_effects(tried.residuals, tried.candidates, tests)
    return found


def _judged_with_second(
    item: Candidate, other: SecondRunEffect, tried: Survey, report_step: ReportStep
) -> Candidate:
    """Return the candidate with its evidence from rows from which the other effect is subtracted.

    p is at least the p among the runs, with the other effect in the model.
    """
    beyond = replace(tried, residuals=without(tried.residuals, other))
    judged = with_evidence(item, beyond, Null(beyond.residuals), tried.absent, report_step)
    among = min(1.0, other.p_value * tried.absent * tried.looks)
    return replace(judged, p_corrected=max(judged.p_corrected, among), second_of_runs=other)


def _beyond_steps(residuals: Residuals, found: Detections) -> Residuals:
    """Return the residuals without the steps that the forward search found together with its lines;
    a line that is smaller than a step would be lost in them."""
    steps = [(step.time_s, step.size_arcsec) for step in found.steps if step.time_s is not None]
    if not steps or not found.causes:
        return residuals
    solution = residuals.solution
    return Residuals(fit(solution.terms, without_steps(solution.observations, steps)))


def _largest_sure(item: Candidate, tried: Survey, null: Null, report_step: ReportStep) -> Candidate:
    """Return, with evidence, a regular cause or a smaller one with the same name.

    The largest significant cause is returned: slow noise may explain a slow line but does not hide
    a fast line. If no cause is significant, the candidate is returned.
    """
    judged = with_evidence(item, tried, null, tried.absent, report_step)
    if judged.p_corrected < SIGNIFICANCE:
        return judged
    for cause in tried.detections.causes:
        if cause is item.regular or cause.effect.name != item.name:
            continue
        for line in regular_candidates(tried.residuals, [cause], tried.absent * tried.looks):
            smaller = with_evidence(line, tried, null, tried.absent, report_step)
            if smaller.p_corrected < SIGNIFICANCE:
                return smaller
    return judged


def _with_forms(parts: list[Candidate], forms: list[Candidate], tried: Survey) -> list[Candidate]:
    """Return the products of parts. A recorded condition, or a form of it, comes first if its ΔBIC
    exceeds that of the product before by AS_GOOD.

    Otherwise the simpler product describes the error. The c₀ or lag of a form counts as a
    coefficient.
    """

    def bic_of(item: Candidate) -> float:
        return delta_bic(item.gain, item.rank + is_searched_form(item.effect), 1.0, item.rows)

    for item in forms:
        first = next(iter(parts), None)
        if item.evidence is None or item.p_corrected >= SIGNIFICANCE or not tried.confirmed(item):
            continue
        stated = first is not None and first.p_corrected < SIGNIFICANCE and tried.confirmed(first)
        if not stated or first is None or bic_of(item) > bic_of(first) + AS_GOOD:
            parts = [item, *parts]
    return parts


def _judged_product(
    item: Candidate, real: Candidate | None, tried: Survey, null: Null, report_step: ReportStep
) -> Candidate:
    """Return a product of parts, with its evidence if the product may be stated as a
    description."""
    ahead = real is None or bic_with(item, real) > -FAR_BEHIND
    if item.p_corrected >= NEAR_P or not ahead:
        return item
    if real is None or not same_columns(item, real):
        own = with_evidence(item, tried, null, 1, report_step)
        if real is None or real.second_of_runs is not None:
            return own
        return with_noise_of_another(own, real, tried, null, 1, report_step)
    assert real.evidence is not None
    score = real.evidence.base.score(item.effect, item.nonlinear)
    settled = with_gain_of(item, replace(real.evidence, score=score), tried, 1)
    return replace(settled, held_out=real.held_out, improvement=real.improvement)
