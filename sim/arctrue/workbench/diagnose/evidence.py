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
from arctrue.workbench.diagnose.candidate import (
    RUNS_ARE_THE_SAMPLE,
    Candidate,
    SecondRunEffect,
    delta_bic,
    explained_arcsec,
    happens_once,
    is_line,
    rows_moved,
    sizes_arcsec,
)
from arctrue.workbench.diagnose.candidates import (
    looked_for,
    regular_candidates,
    tried_above,
    tried_effects,
    tried_products,
    with_regular,
)
from arctrue.workbench.diagnose.classes import of_its_order
from arctrue.workbench.diagnose.every_pass import at_other_speeds
from arctrue.workbench.diagnose.of_the_runs import leaves_the_index, p_among_the_runs
from arctrue.workbench.diagnose.regular import Findings
from arctrue.workbench.diagnose.second_run_effect import second_run_effects, without
from arctrue.workbench.diagnose.survey import (
    Survey,
    fit_of_channels,
    takes_most,
)
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import absent_effects
from arctrue.workbench.inference.at_its_level import gains_at_its_level
from arctrue.workbench.inference.block_share import block_share
from arctrue.workbench.inference.canonical_correlation import canonical_correlations
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.forward.cycles import cycle_change, p_among_cycles, run_change
from arctrue.workbench.inference.forward.of_solution import without_steps
from arctrue.workbench.inference.held_out import falls, held_out_with
from arctrue.workbench.inference.likelihood_ratio import (
    MUCH_MORE,
    Evidence,
    Null,
    evidence,
    evidence_with,
    with_index_as_known,
    without_slow_noise,
)
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import (
    SIGNIFICANCE,
    corrected_p_value,
    single_p_value,
)
from arctrue.workbench.inference.solution import Solution

NEAR_P = 0.3
"""An effect whose p in the first test is below this value may be named; the noise is therefore
estimated anew with this effect in the model."""
OF_ITS_SIZE = 0.2
"""Largest p, in the first test, of an effect that slow noise may have absorbed. Noise that has
absorbed an effect is about as large as the effect, so that the effect is not far below its standard
uncertainty. An effect that does not exist passes this limit with at most this probability."""
MOST_WEIGHED = 6
"""Largest number of candidates of the catalogue for which the noise is estimated anew."""
FAR_BEHIND = 60.0
"""A candidate needs no noise estimate of its own if its ΔBIC is lower than that of a real effect by
more than this."""
SAME_BLOCK = 1e-6
"""Relative tolerance of a gain and of a canonical correlation; it allows for rounding in equal
columns."""
AS_GOOD = 6.0
"""ΔBIC by which other settings or search parameters of an effect must be ahead to replace the first
ones: odds of 20 to 1."""


def survey(
    residuals: Residuals,
    effects: Mapping[str, type[Effect]],
    matters_arcsec: float,
    report_step: ReportStep,
    *,
    negligible: bool = True,
    looks: int = 1,
    findings: Findings | None = None,
) -> Survey:
    """Test every effect and every product of parts with the model of ``residuals``.

    Without ``negligible``, effects that are far too small to matter get no noise estimate of their
    own, because no verdict depends on them. An effect with a search is tested again even if the
    model has it, because it may exist a second time with other search parameters. ``looks``: number
    of such surveys that the diagnosis makes. ``findings``: results of a forward search with this
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
    found = Findings() if findings is None else findings
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
    first product of parts gets evidence too if it can be ahead of the real effect.
    """
    null = Null(tried.residuals)
    beyond = replace(tried, residuals=_beyond_steps(tried.residuals, tried.findings))
    null_of_lines = null if beyond.residuals is tried.residuals else Null(beyond.residuals)
    waiting = _near_to_a_name(tried)
    products = tried.parts[:1]
    if not negligible:
        waiting = [item for item in waiting if tried.may_matter(item)]
        products = [item for item in products if tried.may_matter(item)]
    together = _second_run_effects(tried)
    named = {item.name for item in waiting}
    waiting += [item for item in tried.candidates if item.name in together.keys() - named]
    judged: dict[str, Candidate] = {}
    real: Candidate | None = None
    for _ in range(MOST_WEIGHED):
        if real is not None:
            waiting = _may_come_before(waiting, real)
        if not waiting:
            break
        item = waiting.pop(0)
        if item.name in together:
            item = _judged_with_second(item, together[item.name], tried, report_step)
        elif item.regular is not None:
            item = _largest_sure(item, beyond, null_of_lines, report_step)
        else:
            item = _judged(item, tried, null, tried.absent, report_step)
        judged[item.name] = item
        if (
            item.p_corrected < SIGNIFICANCE
            and tried.confirmed(item)
            and at_other_speeds(item)
            and (real is None or item.delta_bic > real.delta_bic)
        ):
            real = item
            waiting = _best_with(waiting, real)
    if real is not None and real.second_of_runs is None:
        first = real
        judged = {
            name: _with_noise_of_another(item, first, tried, null, tried.absent, report_step)
            for name, item in judged.items()
        }
    parts = [
        *(_judged_product(item, real, tried, null, report_step) for item in products),
        *tried.parts[len(products) :],
    ]
    candidates = [judged.get(item.name, item) for item in tried.candidates]
    if real is not None:
        anew = _with_noise_of([*candidates, *parts], real)
        candidates, parts = anew[: len(candidates)], anew[len(candidates) :]
    candidates.sort(key=lambda item: (-item.delta_bic, item.p_corrected))
    return replace(tried, candidates=candidates, parts=parts)


def described_above(tried: Survey, report_step: ReportStep) -> Candidate | None:
    """Return a product of parts with a line of the capture above the orders of the survey's
    products, if it passes their tests; otherwise None."""
    found = next(iter(tried_above(tried.residuals, tried.looks)), None)
    if found is None:
        return None
    item = _judged(found, tried, Null(tried.residuals), 1, report_step)
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


def _score_with(items: Sequence[Candidate], real: Candidate) -> None:
    """Score all candidates at once, so that :func:`_gain_with` can read the stored scores."""
    assert real.evidence is not None
    real.evidence.base.scores([(item.effect, item.nonlinear) for item in items])


def _gain_with(item: Candidate, real: Candidate) -> float:
    """Return the candidate's gain with the noise of a real effect, scaled like the effect's own
    gain.

    The scale is the ratio of the real effect's gain, for which the noise was estimated anew, to its
    gain in the score test.
    """
    assert real.evidence is not None
    scale = real.gain / max(real.evidence.score.gain, 1e-300)
    return real.evidence.base.score(item.effect, item.nonlinear).gain * scale


def _bic_with(item: Candidate, real: Candidate) -> float:
    """Return ΔBIC of a candidate minus ΔBIC of a real effect, both with the noise of the real
    effect."""
    assert real.evidence is not None
    rows = rows_moved(item.size_arcsec, real.evidence.base.solution)
    return delta_bic(_gain_with(item, real), item.rank, item.trials, rows) - real.delta_bic


def _may_come_before(items: Sequence[Candidate], real: Candidate) -> list[Candidate]:
    """Return the candidates with nearly the ΔBIC of the real effect, or with a larger gain.

    A candidate with a larger gain may be a larger effect that contains the real effect. A candidate
    that explains more error than a line may be named before it, however far it is behind.

    The disc order at which a line was found is always included, however far it is behind the line.
    """
    _score_with(items, real)
    return [
        item
        for item in items
        if _bic_with(item, real) > -FAR_BEHIND
        or _gain_with(item, real) > real.gain
        or _is_larger_than_a_line(item, real)
        or (real.effect.unspecific and of_its_order(real, item))
    ]


def _is_larger_than_a_line(item: Candidate, real: Candidate) -> bool:
    return (
        is_line(real)
        and not is_line(item)
        and not happens_once(item)
        and explained_arcsec(item) > explained_arcsec(real)
    )


def _best_with(items: Sequence[Candidate], real: Candidate) -> list[Candidate]:
    _score_with(items, real)
    return sorted(items, key=lambda item: -_bic_with(item, real))


def _with_noise_of(items: Sequence[Candidate], real: Candidate) -> list[Candidate]:
    """Give each candidate without its own evidence the gain with the noise of the real effect."""
    assert real.evidence is not None
    base = real.evidence.base
    _score_with([item for item in items if item.evidence is None], real)
    found = []
    for item in items:
        if item.evidence is None and (gain := _gain_with(item, real)) > item.gain:
            score = base.score(item.effect, item.nonlinear)
            rows = rows_moved(item.size_arcsec, base.solution)
            item = replace(
                item,
                gain=gain,
                rank=score.rank,
                solution=base.solution_with(item.effect, item.nonlinear, score),
                rows=rows,
                delta_bic=delta_bic(gain, score.rank, item.trials, rows),
            )
        found.append(item)
    return found


def _judged(
    item: Candidate, tried: Survey, null: Null, candidates: int, report_step: ReportStep
) -> Candidate:
    """Return the candidate with its evidence, and with its errors on held-out rows if it is
    significant and matters."""
    residuals = tried.residuals
    report_step(f"the noise with {item.name} in the model")
    found = evidence(null, item.effect, item.nonlinear)
    if found.score.gain > MUCH_MORE * residuals.score(item.effect, item.nonlinear).gain:
        if isinstance(item.effect, ProductOfParts):
            item, found = _product_in_less_noise(item, found, tried, null)
        else:
            item, found = _in_less_noise(item, found, residuals, null)
    return _tested(item, found, tried, candidates, report_step)


def _with_noise_of_another(
    item: Candidate,
    other: Candidate,
    tried: Survey,
    null: Null,
    candidates: int,
    report_step: ReportStep,
) -> Candidate:
    """Return the candidate with the noise estimated with another effect, if the candidate's gain is
    much larger with that noise; otherwise return the candidate unchanged.

    The noise estimated with the candidate itself may still absorb the candidate as slow noise.
    """
    if item is other or item.evidence is None or other.evidence is None:
        return item
    found = evidence_with(other.evidence.base, null, item.effect, item.nonlinear)
    if found.gain < MUCH_MORE * item.evidence.gain:
        return item
    return _tested(item, found, tried, candidates, report_step)


def _tested(
    item: Candidate, found: Evidence, tried: Survey, candidates: int, report_step: ReportStep
) -> Candidate:
    """Return the candidate with this evidence, and with its errors on held-out rows if it is
    significant and matters."""
    item = _settled(item, found, tried, candidates)
    of_rows = found.index_share < RUNS_ARE_THE_SAMPLE
    if item.regular is not None:
        # The candidate has passed the prediction of whole blocks, a stricter test than the
        # prediction of rows from their neighbours.
        return item
    if item.p_corrected < SIGNIFICANCE and tried.matters(item) and of_rows:
        report_step(f"held-out rows for {item.name}")
        base = found.base.solution
        before, after = held_out_with(
            base.terms, item.term, base.observations, base.context, base.noise
        )
        # A product of parts describes the observation; it does not name a cause.
        named = item.asked is not None
        share = block_share(found.base, item.effect, item.nonlinear) if named else None
        improvement = falls(before, after, base.noise)
        return replace(item, held_out=after, improvement=improvement, share=share)
    return item


def _second_run_effects(tried: Survey) -> dict[str, SecondRunEffect]:
    """Return the effects that explain the offsets of the runs only together with another effect."""
    change = tried.findings.cycles
    if change is None or not change.of_runs:
        return {}
    return second_run_effects(tried.residuals, tried.candidates, tried.absent * tried.looks)


def _judged_with_second(
    item: Candidate, other: SecondRunEffect, tried: Survey, report_step: ReportStep
) -> Candidate:
    """Return the candidate with its evidence from rows from which the other effect is subtracted.

    p is at least that among the runs, with the other effect in the model.
    """
    beyond = replace(tried, residuals=without(tried.residuals, other))
    judged = _judged(item, beyond, Null(beyond.residuals), tried.absent, report_step)
    among = min(1.0, other.p_value * tried.absent * tried.looks)
    return replace(judged, p_corrected=max(judged.p_corrected, among), second_of_runs=other)


def _beyond_steps(residuals: Residuals, found: Findings) -> Residuals:
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
    judged = _judged(item, tried, null, tried.absent, report_step)
    if judged.p_corrected < SIGNIFICANCE:
        return judged
    for cause in tried.findings.causes:
        if cause is item.regular or cause.effect.name != item.name:
            continue
        for line in regular_candidates(tried.residuals, [cause], tried.absent * tried.looks):
            smaller = _judged(line, tried, null, tried.absent, report_step)
            if smaller.p_corrected < SIGNIFICANCE:
                return smaller
    return judged


def _in_less_noise(
    item: Candidate, found: Evidence, residuals: Residuals, null: Null
) -> tuple[Candidate, Evidence]:
    """Return the effect's best settings and search parameters, with the noise estimated anew for
    each, and their evidence.

    Without the effect in the model, the noise contains the effect and hides smaller details: the
    lines near a gear's tooth count, or the small difference of an order from a whole number.
    """
    best = None if item.asked is None else looked_for(item.asked, found.base)
    if best is None:
        return item, found
    form, nonlinear, trials = best
    score, rows = (
        found.base.score(form, nonlinear),
        rows_moved(item.size_arcsec, residuals.solution),
    )
    before = delta_bic(found.score.gain, found.score.rank, item.trials, rows)
    if delta_bic(score.gain, score.rank, trials, rows) < before + AS_GOOD:
        return item, found
    anew = evidence(null, form, nonlinear)
    before = delta_bic(found.gain, found.score.rank, item.trials, rows)
    if delta_bic(anew.gain, anew.score.rank, trials, rows) < before + AS_GOOD:
        return item, found
    return replace(item, effect=form, nonlinear=nonlinear, trials=trials), anew


def _product_in_less_noise(
    item: Candidate, found: Evidence, tried: Survey, null: Null
) -> tuple[Candidate, Evidence]:
    """Return the product of parts that is best with less noise, and its evidence.

    While no product is in the model, slow noise absorbs a slow error, so that gains with that noise
    cannot rank two products: the product that leaves the smaller error may gain less.
    """
    others = tried_products(found.base, tried.looks)
    if not others or others[0].effect.parts == item.effect.parts:
        return item, found
    best = others[0]
    anew = evidence(null, best.effect, {})
    if best.rank == 0 or anew.score.rank == 0:
        return item, found
    rows = rows_moved(item.size_arcsec, tried.base)
    before = delta_bic(found.gain, found.score.rank, item.trials, rows)
    if delta_bic(anew.gain, anew.score.rank, best.trials, rows) < before + AS_GOOD:
        return item, found
    return best, anew


def _judged_product(
    item: Candidate, real: Candidate | None, tried: Survey, null: Null, report_step: ReportStep
) -> Candidate:
    """Return a product of parts, with its evidence if the product may be stated as a
    description."""
    ahead = real is None or _bic_with(item, real) > -FAR_BEHIND
    if item.p_corrected >= NEAR_P or not ahead:
        return item
    if real is None or not _same_columns(item, real):
        own = _judged(item, tried, null, 1, report_step)
        if real is None or real.second_of_runs is not None:
            return own
        return _with_noise_of_another(own, real, tried, null, 1, report_step)
    assert real.evidence is not None
    score = real.evidence.base.score(item.effect, item.nonlinear)
    settled = _settled(item, replace(real.evidence, score=score), tried, 1)
    return replace(settled, held_out=real.held_out, improvement=real.improvement)


def _same_columns(item: Candidate, real: Candidate) -> bool:
    """Tell whether both effects have the same block of columns up to a linear transformation, such
    as a warm centre and order 1 times the temperature."""
    assert real.evidence is not None
    if real.effect.search or item.rank != real.rank:
        return False
    base = real.evidence.base
    gain = base.score(item.effect, item.nonlinear).gain
    if abs(gain - real.evidence.score.gain) > SAME_BLOCK * real.evidence.score.gain:
        return False
    correlations = canonical_correlations(base, item.term, real.term)
    return bool(correlations.size == item.rank and correlations[-1] > 1.0 - SAME_BLOCK)


def _settled(item: Candidate, found: Evidence, tried: Survey, candidates: int) -> Candidate:
    """Return the candidate with the gain, size and p that follow from its evidence."""
    solution = found.base.solution_with(item.effect, item.nonlinear, found.score)
    size_arcsec = sizes_arcsec(found.base.solution, solution)
    rank, rows = found.score.rank, rows_moved(size_arcsec, tried.base)
    p_value = corrected_p_value(
        found.gain, rank, item.charged_trials, candidates * tried.looks, found.freedom
    )
    if found.index_share >= RUNS_ARE_THE_SAMPLE and tried.residuals.observations.runs:
        among = p_among_the_runs(tried.residuals, item.effect, item.nonlinear)
        p_value = max(p_value, min(1.0, among * candidates * tried.looks))
    # A product of parts is the best of many and may hide the changes that the model showed.
    offsets_decide = tried.findings.cycles is not None and item.level_trials is not None
    if offsets_decide or cycle_change(solution, SIGNIFICANCE) or run_change(solution, SIGNIFICANCE):
        among = p_among_cycles(tried.base, solution)
        tests = candidates if item.level_trials is None else candidates * item.level_trials
        p_value = max(p_value, min(1.0, among * tests * tried.looks))
    p_value = max(p_value, _p_among_places(item, found, solution, tried, candidates))
    if isinstance(item.effect, ProductOfParts):
        p_value = max(p_value, _p_at_its_level(item, found, solution, tried, candidates))
    return replace(
        item,
        evidence=found,
        gain=found.gain,
        rank=rank,
        solution=solution,
        size_arcsec=size_arcsec,
        p_corrected=p_value,
        rows=rows,
        delta_bic=delta_bic(found.gain, rank, item.trials, rows),
    )


def _p_at_its_level(
    item: Candidate, found: Evidence, solution: Solution, tried: Survey, candidates: int
) -> float:
    """Return p of a product of parts in noise whose level changes with time; 0 in other noise.

    The search chooses among so many products that one of them follows the first gust.
    """
    gains = gains_at_its_level(
        found.base,
        item.effect,
        item.nonlinear,
        found.score,
        takes_most=takes_most(solution, tried.base),
    )
    tests, rank = candidates * tried.looks, found.score.rank
    return max(
        (
            corrected_p_value(one.gain, rank, item.charged_trials, tests, one.freedom)
            for one in gains
        ),
        default=0.0,
    )


def _p_among_places(
    item: Candidate, found: Evidence, solution: Solution, tried: Survey, candidates: int
) -> float:
    """Return p of an effect that every pass of the reference repeats at the same places, with the
    places as the sample; 0 for any other effect, and if the capture shows it too."""
    visits, rows = tried.residuals.visits, tried.residuals.observations.reference
    if visits is None or rows is None or found.score.rank == 0:
        return 0.0
    in_capture = tried.residuals.whitened_columns(item.effect, item.nonlinear)[0]
    if in_capture is not None and in_capture.any():
        return 0.0
    change = (
        solution.reference_prediction_arcsec() - found.base.solution.reference_prediction_arcsec()
    )
    single = visits.p_of(change, found.score.rank)
    placed = float(-np.expm1(max(item.charged_trials, 1.0) * np.log1p(-min(single, 1.0 - 1e-15))))
    return min(1.0, placed * candidates * tried.looks)
