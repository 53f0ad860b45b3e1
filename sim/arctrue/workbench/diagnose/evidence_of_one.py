"""Evidence of one effect: its likelihood ratio with newly estimated noise, its p, and its errors on
held-out rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from arctrue.base.progress import ReportStep
from arctrue.workbench.diagnose.candidate import (
    RUNS_ARE_THE_SAMPLE,
    Candidate,
    delta_bic,
    rows_moved,
    sizes_arcsec,
)
from arctrue.workbench.diagnose.candidates import looked_for, tried_products
from arctrue.workbench.diagnose.condition_forms import is_searched_form
from arctrue.workbench.diagnose.of_the_runs import p_among_the_runs
from arctrue.workbench.diagnose.survey import Survey, takes_most
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.at_its_level import gains_at_its_level
from arctrue.workbench.inference.block_share import block_share
from arctrue.workbench.inference.forward.cycles import cycle_change, p_among_cycles, run_change
from arctrue.workbench.inference.held_out import falls, held_out_with
from arctrue.workbench.inference.likelihood_ratio import (
    MUCH_MORE,
    Evidence,
    Null,
    evidence,
    evidence_with,
)
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE, corrected_p_value
from arctrue.workbench.inference.slow_offsets import p_in_slower_noise
from arctrue.workbench.inference.solution import Solution

AS_GOOD = 6.0
"""ΔBIC by which other settings or search parameters of an effect must be ahead to replace the first
ones: odds of 20 to 1."""


def with_evidence(
    item: Candidate, tried: Survey, null: Null, candidates: int, report_step: ReportStep
) -> Candidate:
    """Return the candidate with its evidence, and with its errors on held-out rows if it is
    significant and matters."""
    residuals = tried.residuals
    report_step(f"the noise with {item.name} in the model")
    found = evidence(null, item.effect, item.nonlinear)
    before = residuals.score(item.effect, item.nonlinear).gain
    # The search for a form used the white part of the noise, which did not absorb the error.
    if found.score.gain > MUCH_MORE * before and not is_searched_form(item.effect):
        if isinstance(item.effect, ProductOfParts):
            item, found = _product_in_less_noise(item, found, tried, null)
        else:
            item, found = _in_less_noise(item, found, residuals, null)
    return _tested(item, found, tried, candidates, report_step)


def with_noise_of_another(
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
    item = with_gain_of(item, found, tried, candidates)
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
    cannot rank two products: the product that leaves the smaller error may gain less. Slow noise
    also shortens the fitted time constant of a settling.
    """
    others = tried_products(found.base, tried.looks)
    if not others or others[0].effect.settings == item.effect.settings:
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


def with_gain_of(item: Candidate, found: Evidence, tried: Survey, candidates: int) -> Candidate:
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
    offsets_decide = tried.detections.cycles is not None and item.level_trials is not None
    if offsets_decide or cycle_change(solution, SIGNIFICANCE) or run_change(solution, SIGNIFICANCE):
        among = p_among_cycles(tried.base, solution)
        tests = candidates if item.level_trials is None else candidates * item.level_trials
        p_value = max(p_value, min(1.0, among * tests * tried.looks))
    among_places = _p_among_places(item, found, solution, tried)
    in_slower_noise = p_in_slower_noise(found.base, item.effect, item.nonlinear)
    for single in (among_places, in_slower_noise):
        p_value = max(p_value, _p_of_all(single, item, candidates * tried.looks))
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

    The search tries so many products that one of them would fit the first loud part of the noise.
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


def _p_of_all(single: float, item: Candidate, tests: float) -> float:
    """Return p over the trials of the candidate's search, and over several tests."""
    placed = -np.expm1(max(item.charged_trials, 1.0) * np.log1p(-min(single, 1.0 - 1e-15)))
    return min(1.0, float(placed) * tests)


def _p_among_places(item: Candidate, found: Evidence, solution: Solution, tried: Survey) -> float:
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
    return visits.p_of(change, found.score.rank)
