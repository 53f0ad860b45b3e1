"""Explains a measurement set: adds effect after effect to the model, until the diagnosis names no
further effect.

Each step estimates the noise anew. At the end, added effects that later effects replace are
dropped. The model is then fitted without each of the remaining added effects in turn, which gives
the error that each effect explains.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from arctrue.base.progress import ReportStep
from arctrue.workbench.diagnose.diagnosis import MATTERS_COUNTS, Diagnosis, diagnose
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.left import Left, left_by
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.growth import (
    AlreadyThereError,
    NotTestableError,
    add_effect,
    fitted,
    names_of,
    step_of,
)
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.observations import Observations

MOST_ADDED = 16
"""Largest number of effects that are added to one set; each effect needs a diagnosis, which takes
seconds."""


@dataclass(frozen=True, eq=False)
class ExplainedCause:
    """One effect that the explanation added."""

    entry: ModelEffect
    taken_arcsec: Mapping[str, float]
    """Held-out error that the effect explains, by channel: √(RMS² without it − RMS² with it), at
    least 0."""

    @property
    def size_arcsec(self) -> float:
        """Return the explained error in the channel where it is largest."""
        return max(self.taken_arcsec.values(), default=0.0)


@dataclass(frozen=True, slots=True)
class NotSeparated:
    """Causes that fit these rows equally well, and the measurement that would separate them."""

    effects: tuple[str, ...]
    """Names of the effects; the named effect comes first."""
    description: str | None = None
    """Description of a product of parts that fits equally well and is in no catalogue."""
    next_measurement: str | None = None
    """Description of the measurement to make; None if no proposed measurement would separate the
    causes."""
    next_measurement_kind: str | None = None
    why: str | None = None
    """Reason for doubt about the named effect, if no other cause fits equally well."""

    def sentence(self) -> str:
        """Return the alternatives as a sentence, which is printed and stored in the model file."""
        names = ", ".join(self.effects)
        if self.description is not None:
            names += f", or {self.description}"
        would = self.next_measurement or "none of the single measurements that were calculated"
        if len(self.effects) == 1 and self.description is None:
            return (
                f"This set cannot confirm {names}: {self.why}. "
                f"A measurement that would confirm it: {would}."
            )
        return (
            f"This set cannot distinguish between {names}. "
            f"A measurement that would distinguish them: {would}."
        )


@dataclass(frozen=True, eq=False)
class Explanation:
    """A model with every named effect, and the verdict on its residuals."""

    model: Model
    causes: tuple[ExplainedCause, ...]
    """Causes sorted by the error that they explain, the largest first."""
    dropped: tuple[str, ...]
    """Effects that were added and that the final model does not need."""
    left: Left
    verdict: Diagnosis
    """Verdict on the final model."""
    similar: tuple[NotSeparated, ...] = ()
    """Alternatives to each added cause, and to the effect in the final verdict."""


def not_separated(found: Diagnosis) -> NotSeparated | None:
    """Return the alternatives to the effect in a diagnosis; None if the diagnosis states no
    alternative."""
    decision = found.decision
    if found.verdict not in ("named", "ambiguous"):
        return None
    names = tuple(dict.fromkeys([*found.effect_class, *decision.look_alikes]))
    words = found.description if found.verdict == "ambiguous" else None
    if found.verdict == "named" and len(names) < 2:
        return None
    why = decision.unconfirmed
    return NotSeparated(names, words, found.next_measurement, found.next_measurement_kind, why)


def explain(
    model: Model,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    measurement: str,
    *,
    matters_counts: float = MATTERS_COUNTS,
    report_step: ReportStep = lambda text: None,
) -> Explanation:
    """Add the effects that the diagnosis names, drop effects that others replace, and diagnose
    again.

    All effects of ``model`` stay. Raises NotTestableError for an effect of ``model`` that the set
    cannot test.
    """
    grown, solution = fitted(model, observations, effects)
    kept = len(grown.effects)
    if not grown.history:
        step = step_of("fit", names_of(grown), measurement, solution)
        grown = replace(grown, history=[step])
    verdict = _verdict(solution, observations, effects, matters_counts)
    # The alternatives to each effect of the model, in the order of its effects.
    similar: list[NotSeparated | None] = [None] * kept
    while len(grown.effects) - kept < MOST_ADDED:
        # A refused effect ends the explanation only if no other effect would be named.
        next_effect = verdict.named or verdict.instead
        if next_effect is None:
            break
        name, settings = next_effect.name, _own_settings(next_effect.effect)
        report_step(f"adding {name}")
        try:
            further, solution = add_effect(
                grown, name, settings, observations, effects, measurement
            )
        except (AlreadyThereError, NotTestableError):
            break
        if len(further.effects) == len(grown.effects):
            # The model had the effect with other settings; the effect has moved to the end.
            del similar[grown.names().index(name)]
        grown = further
        similar.append(not_separated(verdict))
        report_step("diagnosing the remaining error")
        verdict = _verdict(solution, observations, effects, matters_counts)
    added = grown.names()
    grown, solution, idle = _without_idle(grown, solution, kept, observations, effects, measurement)
    dropped = [added[place] for place in idle]
    for place in idle:
        del similar[place]
    if dropped:
        report_step("diagnosing the remaining error")
        verdict = _verdict(solution, observations, effects, matters_counts)
    with_all = left_by(solution)
    causes: list[tuple[ExplainedCause, NotSeparated | None]] = []
    for place in range(kept, len(grown.effects)):
        report_step(f"leaving {grown.effects[place].name} out once")
        _, without = fitted(_less(grown, place), observations, effects)
        cause = ExplainedCause(grown.effects[place], _taken(left_by(without), with_all))
        causes.append((cause, similar[place]))
    causes.sort(key=lambda item: -item[0].size_arcsec)
    unclear = [*(item for _, item in causes), not_separated(verdict)]
    return Explanation(
        grown,
        tuple(cause for cause, _ in causes),
        tuple(dropped),
        with_all,
        verdict,
        tuple(item for item in unclear if item is not None),
    )


def _without_idle(
    model: Model,
    solution: Solution,
    kept: int,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    measurement: str,
) -> tuple[Model, Solution, list[int]]:
    """Drop added effects that other effects have made idle; test the latest first. Also return
    their places in ``model``, the last one first.

    An effect is idle if the Bayesian information criterion without it is not larger. The effect
    that was added last is kept: the diagnosis named it when all other effects were in the model.
    """
    dropped = []
    for place in reversed(range(kept, len(model.effects) - 1)):
        name = model.effects[place].name
        shrunk, without = fitted(_less(model, place), observations, effects)
        if without.bic <= solution.bic:
            shrunk.history.append(step_of("drop", name, measurement, without))
            model, solution = shrunk, without
            dropped.append(place)
    return model, solution, dropped


def _less(model: Model, place: int) -> Model:
    """Return the model without the effect at ``place``."""
    entries = [*model.effects[:place], *model.effects[place + 1 :]]
    return replace(model, effects=entries, history=list(model.history))


def _own_settings(effect: Effect) -> dict[str, object]:
    """Return the settings that differ from the defaults, such as multiples of a tooth count."""
    return {
        key: value for key, value in effect.settings.items() if value != effect.defaults.get(key)
    }


def _verdict(
    solution: Solution,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    matters_counts: float,
) -> Diagnosis:
    terms = list(solution.terms)
    return diagnose(observations, terms, effects, matters_counts=matters_counts, instead=True)


def _taken(without: Left, with_it: Left) -> dict[str, float]:
    """Return the held-out error that the omitted effect explains, by channel."""
    return {
        channel: float(np.sqrt(max(value**2 - with_it.heldout_rms_arcsec[channel] ** 2, 0.0)))
        for channel, value in without.heldout_rms_arcsec.items()
        if channel in with_it.heldout_rms_arcsec
    }
