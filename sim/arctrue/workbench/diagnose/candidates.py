"""Tests every effect and every product of parts (condition × wave) on the residuals of one model,
with the noise of this model.

This is the first stage after the faults of the data: searches and score tests.
:mod:`arctrue.workbench.diagnose.evidence` then estimates the noise anew for candidates that may be
named.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from arctrue.base.progress import ReportStep
from arctrue.workbench.diagnose.candidate import Candidate, delta_bic, rows_moved, sizes_arcsec
from arctrue.workbench.diagnose.condition_forms import best_form, straight
from arctrue.workbench.diagnose.detections import Detections, RegularCause
from arctrue.workbench.diagnose.parts_range import LEAST_WAVE, only_cancels
from arctrue.workbench.diagnose.parts_scan import (
    PartsCandidate,
    best_parts,
    parts_above,
    share_of_forms,
)
from arctrue.workbench.effects.base import Effect, orders_of_parts
from arctrue.workbench.effects.scalar_effect import ScalarOfEachHead
from arctrue.workbench.inference.likelihood_ratio import with_index_as_known
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.search import places_of
from arctrue.workbench.inference.significance import SIGNIFICANCE, corrected_p_value
from arctrue.workbench.observations import Observations

MOST_LEFT = 0.5
"""A slow product comes before the other products if it leaves less than this share of the error's
variance: it then explains more of the error than everything else together."""


def tried_effects(
    residuals: Residuals, effects: Mapping[str, type[Effect]], tests: int, report_step: ReportStep
) -> tuple[list[Candidate], dict[str, list[str]]]:
    """Return a candidate for every effect that the set can test, and the data that the set lacks
    for each other effect.

    An effect gets no candidate if the model explains it completely, or if its search finds no
    values of its search parameters. ``tests``: number of candidates by which each p is corrected.
    """
    found: list[Candidate] = []
    untestable: dict[str, list[str]] = {}
    for name, kind in effects.items():
        effect = kind()
        observations = residuals.observations
        lacking = effect.missing(observations) or _on_an_arc(effect, observations)
        if lacking:
            untestable[name] = lacking
            continue
        report_step(f"trying {name}")
        place = looked_for(effect, residuals)
        if place is None or residuals.score(place[0], place[1]).rank == 0:
            continue
        form, nonlinear, trials = place
        item = _candidate(form, nonlinear, trials, residuals, tests)
        found.append(replace(item, lacking_variety=form.variety(observations), asked=effect))
    return found, untestable


def regular_candidates(
    residuals: Residuals, causes: Sequence[RegularCause], tests: int
) -> list[Candidate]:
    """Return, for each effect that a forward search found, one candidate, which is made from the
    effect's first cause.

    ``causes`` are sorted, the largest first.
    """
    found: dict[str, Candidate] = {}
    for cause in causes:
        form, place = cause.effect.at_place(residuals, cause.nonlinear)
        if form.name in found or residuals.score(form, place).rank == 0:
            continue
        item = _candidate(form, place, cause.trials, residuals, tests)
        found[form.name] = replace(
            item, lacking_variety=form.variety(residuals.observations), regular=cause
        )
    return list(found.values())


def with_regular(
    candidates: Sequence[Candidate], lines: Sequence[Candidate], found: Detections
) -> list[Candidate]:
    """Return the candidates; candidates from a forward search replace other candidates of the same
    name.

    A line is omitted if the forward search covered its rate and found no line there: such a line is
    a resonance driven by noise, or exists in half of the record only. A line above the searched
    rates stays if it is larger than the line of the forward search.
    """
    larger = {
        item.name
        for item in candidates
        for line in lines
        if line.name == item.name
        and line.regular is not None
        and _is_line(item)
        and not found.searched(item.nonlinear)
        and max(item.size_arcsec.values(), default=0.0) > line.regular.taken_arcsec
    }
    kept = [line for line in lines if line.name not in larger]
    names = {line.name for line in kept}
    others = [
        item
        for item in candidates
        if item.name not in names and not (_is_line(item) and found.searched(item.nonlinear))
    ]
    return [*kept, *others]


def _is_line(item: Candidate) -> bool:
    return item.effect.search_kind == "line"


def tried_products(residuals: Residuals, looks: int) -> list[Candidate]:
    """Return the products of parts, best first. ``looks``: number of surveys by which each p is
    corrected.

    The first is the product that leaves the least error, if it is significant and leaves less than
    half of the error's variance. While no product is in the model, slow noise absorbs such a slow
    error, so that gains with that noise cannot rank the products.
    """
    found = _of_parts(best_parts(residuals), residuals, looks)
    shares = [_share_left(item, residuals) for item in found]
    least = min(range(len(found)), key=lambda index: shares[index], default=0)
    if found and shares[least] < MOST_LEFT and found[least].p_corrected < SIGNIFICANCE:
        found.insert(0, found.pop(least))
    return found


def tried_forms(residuals: Residuals, looks: int) -> list[Candidate]:
    """Return the condition and the form of it that :func:`best_form` finds, if the form may be
    stated; otherwise no candidate.

    Until the noise is estimated anew, p follows from the white part of the noise, because slow
    noise may have absorbed the error.
    """
    found = best_form(residuals)
    if found is None or only_cancels(residuals, found.effect, residuals.score(found.effect, {})):
        return []
    share = share_of_forms(residuals.observations)
    p_value = corrected_p_value(found.gain, found.rank, found.trials / share, looks)
    return [
        replace(
            _candidate(effect, {}, found.trials, residuals, 1),
            level_trials=found.trials / share,
            p_corrected=p_value,
        )
        for effect in (straight(found.effect, residuals.observations), found.effect)
    ]


def tried_above(residuals: Residuals, looks: int) -> list[Candidate]:
    """Return the products of parts whose orders are above those of :func:`tried_products`."""
    return _of_parts(parts_above(residuals), residuals, looks)


def _of_parts(parts: Sequence[PartsCandidate], residuals: Residuals, looks: int) -> list[Candidate]:
    """Return products of parts as candidates, in the order of their ΔBIC."""
    found = []
    for item in parts:
        if item.rank > 0:
            tried = _candidate(item.effect, {}, item.trials, residuals, 1)
            p_value = corrected_p_value(item.gain, item.rank, item.level_trials, looks)
            found.append(replace(tried, level_trials=item.level_trials, p_corrected=p_value))
    return sorted(found, key=lambda item: -item.delta_bic)


def _share_left(item: Candidate, residuals: Residuals) -> float:
    """Return the share of the residual variance of the reference that a product leaves; 1 without a
    reference, or if the set has a capture."""
    before = residuals.solution.reference_residual_arcsec()
    after = item.solution.reference_residual_arcsec()
    if residuals.observations.capture is not None or before is None or after is None:
        return 1.0
    return float(np.var(after) / max(float(np.var(before)), 1e-300))


def looked_for(
    effect: Effect, residuals: Residuals
) -> tuple[Effect, dict[str, float], float] | None:
    """Return the settings and search parameters with which an effect fits best, and the number of
    independent values of the search parameters that were tried."""
    form, trials = effect.narrowed(_of_its_offsets(effect, residuals))
    if not form.search:
        return form, {}, trials
    places = places_of(form, residuals)
    if not places:
        return None
    return *form.at_place(residuals, places[0].nonlinear), places[0].trials


def _of_its_offsets(effect: Effect, residuals: Residuals) -> Residuals:
    """Return the residuals by which the heads of an effect are chosen.

    An effect that is constant within each run changes the offsets of the runs. The estimated index
    variance contains these offsets, so that every single head would gain about as much as all heads
    together.
    """
    one_of_many = isinstance(effect, ScalarOfEachHead) and residuals.observations.heads > 2
    return with_index_as_known(residuals) if one_of_many else residuals


def _candidate(
    effect: Effect, nonlinear: dict[str, float], trials: float, residuals: Residuals, tests: int
) -> Candidate:
    score = residuals.score(effect, nonlinear)
    solution = residuals.solution_with(effect, nonlinear, score)
    size_arcsec = sizes_arcsec(residuals.solution, solution)
    rows = rows_moved(size_arcsec, residuals.solution)
    return Candidate(
        effect=effect,
        nonlinear=nonlinear,
        gain=score.gain,
        rank=score.rank,
        trials=trials,
        solution=solution,
        delta_bic=delta_bic(score.gain, score.rank, trials, rows),
        size_arcsec=size_arcsec,
        p_corrected=corrected_p_value(score.gain, score.rank, trials, tests),
        rows=rows,
    )


def _on_an_arc(effect: Effect, observations: Observations) -> list[str]:
    """Return, in words, the data that the set lacks if an order of the effect does not complete
    LEAST_WAVE of a period on the arc of the reference.

    Such an order is a slow curve, like a drift, and contains no information about the disc.
    """
    rows = observations.reference
    if observations.capture is not None or rows is None or effect.search:
        return []
    orders = [*effect.disc_orders({}), *orders_of_parts(effect.in_parts)]
    turns = float(np.ptp(rows.target_rad)) / (2.0 * np.pi)
    if not orders or min(orders) * turns >= LEAST_WAVE:
        return []
    return [f"stations over {LEAST_WAVE:g} of a period of each order"]
