"""Adds an effect to a model, for ``arctrue add`` and for the figures that a diagnosis states."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.every_row import on_every_row
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.likelihood_ratio import Null, evidence
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.search import places_of
from arctrue.workbench.inference.search_parameters import refined
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.fit import white_noise


def settled(solution: Solution) -> Solution:
    """Refine the search parameters and fit every row; a model's history shows the figures of this
    fit."""
    return on_every_row(refined(solution))


def added(effect: Effect, residuals: Residuals) -> Solution | None:
    """Fit the model of ``residuals`` with one more effect; estimate noise and coefficients anew.

    The coefficients of the model must be fitted to this set. The result is None if the search finds
    no values of the search parameters.
    """
    base = residuals.solution
    effect = best_form(effect, residuals)
    place: dict[str, float] = {}
    if effect.search:
        found = likeliest_place(effect, residuals)
        if found is None:
            return None
        effect, place = effect.at_place(residuals, found)
    return settled(fit([*base.terms, Term(effect, place)], base.observations))


def best_form(effect: Effect, residuals: Residuals) -> Effect:
    """Return the form of an effect whose gain minus BIC penalty is largest. The penalty counts the
    parameters of the form and the forms that were tried; the noise is estimated for each form.

    The candidates are the effect itself and the best forms with the noise of the model, with only
    the white part of this noise and, for an effect without a search, with the noise that is
    estimated with the effect.
    """
    if not effect.narrowed_when_added:
        return effect
    null = Null(residuals, search_walk=False)
    noises = [residuals, _white(residuals)]
    if not effect.search:
        noises.append(evidence(null, effect, {}).base)
    forms, tried = [effect], [1.0]
    for seen in noises:
        wanted, trials = effect.narrowed(seen)
        if wanted.settings not in [form.settings for form in forms]:
            forms.append(wanted)
            tried.append(trials)
    if len(forms) < 2:
        return effect
    found: list[tuple[float, int]] = []
    for index, (form, trials) in enumerate(zip(forms, tried, strict=True)):
        place = likeliest_place(form, residuals) if form.search else {}
        if place is not None:
            of_form = evidence(null, form, place)
            columns = residuals.whitened_columns(form, place)
            rows = sum(item.shape[0] for item in columns if item is not None)
            penalty = (of_form.score.rank + len(form.search)) * float(np.log(max(rows, 2)))
            penalty += 2.0 * float(np.log(trials))
            found.append((of_form.gain - penalty, -index))
    return forms[-max(found)[1]] if found else effect


def likeliest_place(effect: Effect, residuals: Residuals) -> Nonlinear | None:
    """Return the likeliest search parameters, with the noise estimated anew for each candidate.

    Noise that was estimated without the effect may contain the effect: lost counts look like slow
    noise. The best search parameters with that noise are therefore compared with the best ones with
    only the white part of that noise.
    """
    places = [
        place.nonlinear
        for seen in (residuals, _white(residuals))
        for place in places_of(effect, seen)[:1]
    ]
    if len(places) < 2 or places[0] == places[1]:
        return places[0] if places else None
    null = Null(residuals, search_walk=False)

    def gain(place: Nonlinear) -> float:
        form = effect if effect.step_at is None else effect.at_place(residuals, place)[0]
        return evidence(null, form, place).gain

    return max(places, key=gain)


def _white(residuals: Residuals) -> Residuals:
    """Return the residuals of the same model with only the white part of its noise."""
    base = residuals.solution
    noise = base.noise
    white = white_noise(
        base.observations,
        (
            None if noise.capture is None else noise.capture.white_rms_arcsec or None,
            None if noise.reference is None else noise.reference.white_rms_arcsec or None,
        ),
    )
    return Residuals(fit(base.terms, base.observations, noise=white))
