"""Fits a model, adds and drops its effects, and records the result of each step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.added import best_form, likeliest_place, settled
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.fixed import with_fixed_coefficients
from arctrue.workbench.inference.left import left_by
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.model import HistoryStep, Model, ModelEffect, ModelTable
from arctrue.workbench.model.stations import on_its_arc
from arctrue.workbench.observations import Observations


class NotTestableError(ValueError):
    """The set cannot test an effect: the set lacks data, or the effect's search finds no values of
    its search parameters."""


class AlreadyThereError(ValueError):
    """The model has the effect already."""


def settle(
    model: Model, observations: Observations, effects: Mapping[str, type[Effect]]
) -> list[Term]:
    """Return the model's terms; search for the missing search parameters, effect by effect.

    On a short arc the default model has fewer orders (:func:`on_its_arc`). Raises NotTestableError
    for an effect that the set cannot test.
    """
    terms: list[Term] = []
    for entry in on_its_arc(model, observations).effects:
        effect = entry.effect(effects)
        lacking = effect.missing(observations)
        if lacking:
            raise NotTestableError(
                f"{entry.name} cannot be tested with this set: it lacks {'; '.join(lacking)}"
            )
        nonlinear = dict(entry.search)
        if effect.search and set(nonlinear) != {item.name for item in effect.search}:
            residuals = Residuals(fit(terms, observations))
            found = likeliest_place(effect, residuals)
            if found is None:
                raise NotTestableError(
                    f"{entry.name} cannot be tested with this set: its search found no values"
                )
            effect, nonlinear = effect.at_place(residuals, found)
        terms.append(Term(effect, nonlinear))
    return terms


def _other_than_usual(effect: Effect) -> dict[str, object]:
    """Return the settings that differ from the effect's defaults; a search may have set some of
    them."""
    return {key: value for key, value in effect.settings.items() if value != effect.defaults[key]}


def fitted(
    model: Model, observations: Observations, effects: Mapping[str, type[Effect]]
) -> tuple[Model, Solution]:
    """Fit the model to every row; return it with its fitted values.

    Raises NotTestableError for an effect that the set cannot test.
    """
    model = on_its_arc(model, observations)
    terms = settle(model, observations, effects)
    solution = settled(fit(terms, observations))
    grown = replace(
        model,
        effects=stored_entries(model.effects, solution),
        reference_offset_arcsec=solution.reference_offset_arcsec,
        reference_temperature_c=observations.reference_temperature_c
        if observations.has_temperature
        else model.reference_temperature_c,
        table=table_of(observations).completed(model.table),
    )
    return grown, solution


def stored_entries(entries: Sequence[ModelEffect], solution: Solution) -> list[ModelEffect]:
    """Return the effects of a model with the results of a fit."""
    observations, parameters = solution.observations, solution.parameters()
    return [
        ModelEffect(
            name=entry.name,
            settings={**entry.settings, **_other_than_usual(term.effect)},
            search={key: float(value) for key, value in term.nonlinear.items()},
            columns=term.effect.column_names(observations),
            coefficients=[float(value) for value in solution.coefficients[solution.part(index)]],
            parameters=parameters[index],
        )
        for index, (entry, term) in enumerate(zip(entries, solution.terms, strict=True))
    ]


def table_of(observations: Observations) -> ModelTable:
    """Return the table of the set; the separation is None for a set without a capture."""
    separation = observations.head_separation_rad
    return ModelTable(
        observations.counts_per_rev, float(np.degrees(separation)) if separation else None
    )


def step_of(action: str, effect: str, measurement: str, solution: Solution) -> HistoryStep:
    """Return a history step with RMS and peak of the residuals, the held-out RMS, and the noise."""
    left = left_by(solution)
    return HistoryStep(
        action,
        effect,
        measurement,
        dict(left.rms_arcsec),
        dict(left.peak_arcsec),
        dict(left.heldout_rms_arcsec),
        dict(left.noise_arcsec),
    )


def names_of(model: Model) -> str:
    """Return the names of the effects for the history; a model without effects is a constant."""
    return ", ".join(model.names()) or "constant"


def add_effect(
    model: Model,
    name: str,
    settings: dict[str, object],
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    measurement: str,
) -> tuple[Model, Solution]:
    """Return the model, fitted with one more effect, and with a new step in its history.

    If the model already has an effect of this name without a search, that effect gets the given
    settings. An effect with a search, or a product of parts with other settings, is added as a
    further effect. Raises AlreadyThereError, NotTestableError, or ValueError for settings.
    """
    model = on_its_arc(model, observations)
    entry = ModelEffect(name, settings)
    entries, action = [*model.effects, entry], "add"
    effect = entry.effect(effects)
    if effect.needs_settings:
        if entry in [ModelEffect(one.name, one.settings) for one in model.effects]:
            raise AlreadyThereError(f"the model has {name} with these settings already")
    elif name in model.names() and not effect.search:
        entries, action = _with_settings(model, name, settings), "set"
    elif not settings and effect.narrowed_when_added and not effect.missing(observations):
        residuals = Residuals(fit(settle(model, observations, effects), observations))
        entries[-1] = replace(entry, settings=_other_than_usual(best_form(effect, residuals)))
    history = list(model.history)
    if not history:
        _, before = fitted(model, observations, effects)
        history.append(step_of("fit", names_of(model), measurement, before))
    grown, solution = fitted(replace(model, effects=entries), observations, effects)
    # The added or changed effect moves to the end, where the commands show it.
    history.append(step_of(action, name, measurement, solution))
    return replace(grown, history=history), solution


def _with_settings(model: Model, name: str, settings: dict[str, object]) -> list[ModelEffect]:
    """Return the model's effects; the effect ``name`` has the new settings and is the last one.

    Raises AlreadyThereError if no setting changes.
    """
    place = model.names().index(name)
    before = model.effects[place]
    changed = {**before.settings, **settings}
    if changed == before.settings:
        raise AlreadyThereError(
            f"the model has {name} already; --set KEY=VALUE changes one of its settings"
        )
    return [*model.effects[:place], *model.effects[place + 1 :], ModelEffect(name, changed)]


def drop_effect(
    model: Model,
    name: str,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    measurement: str,
) -> tuple[Model, Solution]:
    """Return the model, fitted again, without the last effect called ``name``.

    Raises ValueError if the model has no such effect, or no other effect.
    """
    if name not in model.names():
        raise ValueError(f"the model has no {name}; it has: {', '.join(model.names())}")
    if len(model.effects) == 1:
        raise ValueError(f"{name} is the model's only effect: nothing would be left")
    last = len(model.effects) - 1 - model.names()[::-1].index(name)
    kept = [entry for index, entry in enumerate(model.effects) if index != last]
    shrunk, solution = fitted(replace(model, effects=kept), observations, effects)
    step = step_of("drop", name, measurement, solution)
    return replace(shrunk, history=[*model.history, step]), solution


def as_stored(
    model: Model, observations: Observations, effects: Mapping[str, type[Effect]]
) -> Solution:
    """Apply the stored coefficients to another set of the same table.

    Only the constants that belong to the set are fitted (each run's offset, a₀). Raises ValueError
    if a stored effect has no coefficients, or if the set needs other columns than those of the
    stored coefficients.
    """
    terms = model.terms(effects)
    values: list[float] = []
    for entry, term in zip(model.effects, terms, strict=True):
        lacking = term.effect.missing(observations)
        expected = term.effect.column_names(observations)
        if not entry.coefficients:
            raise ValueError(f"{entry.name}: the model file has no coefficients; fit it first")
        if entry.columns != expected and not lacking:
            raise ValueError(
                f"{entry.name}: the model file has {len(entry.columns)} coefficients, this set "
                f"needs {len(expected)}: an effect with its own size in each run cannot be "
                "applied to another set"
            )
        values += entry.coefficients
    return with_fixed_coefficients(terms, observations, np.array(values))
