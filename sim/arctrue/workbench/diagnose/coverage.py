"""Determines the coverage of a verdict: sizes that would have been found, and effects that the set
cannot test."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from arctrue.workbench.diagnose.candidate import RUNS_ARE_THE_SAMPLE, Candidate
from arctrue.workbench.diagnose.lacking import of_the_same_kind
from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.effects.part_conditions import DIRECTION_TIME, Condition, conditions
from arctrue.workbench.effects.product_of_parts import Frame, ProductOfParts
from arctrue.workbench.inference.channels import best_factor
from arctrue.workbench.inference.detectable import (
    SIGNIFICANCE,
    Detectable,
    Refused,
    smallest_detectable,
)
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.disc import BLIND_FACTOR, samples_a_turn
from arctrue.workbench.inference.score_test import Score
from arctrue.workbench.inference.significance import corrected_p_value
from arctrue.workbench.observations import Observations

MOST_UNTESTED = 0.5
"""A set may support the verdict that nothing is missing only if at most this share of the effects
cannot be tested.

The value is chosen, not calibrated. If the set cannot test half of the catalogue, the priors of
:mod:`probabilities` give odds of 1.7 to 1 that nothing is missing: 0.5 : (0.4/2 + 0.09 + 0.01).
Above 3 to 1, evidence is "positive" (Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773); the
odds exceed 3 to 1 if the set can test more than five sixths of the catalogue.
"""
COLOURED_SHARE = 0.99
"""If slow noise is a larger share than this of a row's variance, the set cannot show slow effects.
The slow noise is then ten times the scatter of a single reading, and any effect that changes as
slowly would be taken for noise."""
UNSEEN_SHARE = 0.5
"""Largest share of generic effects whose smallest detectable RMS is above the RMS of the whole
residual. Above this share, the set could not show most effects that may be missing. The value is
chosen, not calibrated."""
GENERIC_ORDERS = (None, 1.0, 2.5, 6.0, 10.5, 25.0)
"""Orders of the angle that represent all orders: slow and fast, whole and half. None is an effect
without a wave."""
HIGHEST_BLIND_ORDER = 1000
"""Highest order up to which blind orders are listed (orders that the heads at their places cannot
show); two heads at 33° have 8 of them. The list is only printed; no verdict depends on it."""


@dataclass(frozen=True)
class Coverage:
    """Effects that were tested, and the smallest size at which each would have been found."""

    smallest: dict[str, Detectable] = field(default_factory=dict)
    """Smallest detectable size of each effect that was tested."""
    untestable: dict[str, list[str]] = field(default_factory=dict)
    """Data that the set lacks, for each effect that was not tested."""
    tested: int = 0
    """Number of effects that were tested. It includes effects whose search found nothing, and
    effects that the model explains completely."""
    blind_orders: list[int] = field(default_factory=list)
    """Disc orders that neither the heads at their places nor the reference can show."""


@dataclass(frozen=True)
class Blindness:
    """Reason why the set cannot show that the model is adequate, and the measurement that could
    show it."""

    reason: str
    next_measurement: str
    next_measurement_kind: str | None = None


def coverage(
    residuals: Residuals,
    candidates: Sequence[Candidate],
    untestable: Mapping[str, list[str]],
    absent: int,
    tested: int,
    refused: Refused,
) -> Coverage:
    """Return the coverage; an effect with a search has the search parameters that fit best.

    ``absent``, ``tested``: numbers of effects that the model lacks, and that were tested.
    ``refused``: limits for an effect that is stated although held-out rows do not show it.
    """
    smallest = {}
    for item in candidates:
        effect, nonlinear = _without_form(item)
        found = smallest_detectable(
            residuals,
            effect,
            nonlinear,
            max(absent, 1) * max(item.charged_trials, 1.0),
            replace(refused, trials=item.trials, rows_by_themselves=RUNS_ARE_THE_SAMPLE),
        )
        if found is not None and found.rms_arcsec:
            smallest[item.name] = found
    return Coverage(smallest, dict(untestable), tested, blind_orders(residuals))


def blind_orders(residuals: Residuals) -> list[int]:
    """Return the orders n with |e^{jnβ} − 1| near 0 for the place β of every further head.

    The highest order is half the number of samples per turn. Orders up to half the number of
    stations of a reference are left out, because the reference shows them.
    """
    rows = residuals.observations.capture
    if rows is None:
        return []
    highest = int(min(samples_a_turn(residuals) / 2.0, HIGHEST_BLIND_ORDER))
    orders = np.arange(1, highest + 1)
    reference = residuals.observations.reference
    seen = 0.0
    if reference is not None:
        stations = np.unique(np.round(np.mod(reference.target_rad, 2.0 * np.pi), 6)).size
        seen = stations / 2.0
    blind = best_factor(rows, orders) < BLIND_FACTOR
    return [int(order) for order in orders[blind & (orders > seen)]]


def blindness(
    residuals: Residuals, found: Coverage, residual_rms_arcsec: Mapping[str, float], matters: float
) -> Blindness | None:
    """Return the reason why the set does not support the verdict "adequate"; None if it supports
    it."""
    return (
        _little_testable(found, heads=residuals.observations.capture is not None)
        or _slow_noise(residuals, matters)
        or _residual_unseen(residuals, residual_rms_arcsec)
    )


def _without_form(item: Candidate) -> tuple[Effect, Nonlinear]:
    """Return the effect in its form without further parameters: the coverage states the size of a
    reversal error, not the width of its transition."""
    if item.asked is not None and len(item.asked.forms()) > 1:
        return item.asked, {}
    return item.effect, item.nonlinear


def effect_or_noise(
    candidates: Sequence[Candidate], tests: int, matters: float
) -> Blindness | None:
    """Return a reason that names the effects that explain the rows as well as slow noise does.

    Only effects that matter are named; the result is None if there is no such effect.

    Such an effect is significant if the noise is estimated with the effect in the model. It is not
    significant with the noise of the model without the effect, which contains more slow noise, and
    the likelihoods cannot distinguish the two models. ``tests``: number of candidates by which the
    effect's p is corrected.
    """
    similar = [
        item.name
        for item in candidates
        if item.evidence is not None
        and max(item.size_arcsec.values(), default=0.0) >= matters
        and _p_with(item, item.evidence.score, tests) < SIGNIFICANCE
    ]
    if not similar:
        return None
    return Blindness(
        f"{' or '.join(similar)} and slow noise explain the rows equally well: the effect is "
        "significant against the scatter of single readings, but not against noise that changes "
        "as slowly as the effect",
        "the same measurement once more, in another order and with the temperature recorded: an "
        "effect repeats, noise does not",
        "again",
    )


def _p_with(item: Candidate, score: Score, tests: int) -> float:
    """Return p of an effect; noise and degrees of freedom are estimated with the effect in the
    model."""
    return corrected_p_value(score.gain, score.rank, item.trials, tests, item.freedom)


def _little_testable(found: Coverage, *, heads: bool) -> Blindness | None:
    """Return a reason if the set cannot test most effects; ``heads``: whether it has a capture."""
    whole = found.tested + len(found.untestable)
    if len(found.untestable) <= MOST_UNTESTED * whole:
        return None
    why = f"{len(found.untestable)} of {whole} effects cannot be tested with it"
    if not heads:
        return Blindness(why, of_the_same_kind(found.untestable))
    lacking = Counter(what for items in found.untestable.values() for what in items)
    most, count = max(lacking.items(), key=lambda item: item[1])
    return Blindness(
        why, f"a set that has {most}: {count} of the effects that were not tested need it"
    )


def _slow_noise(residuals: Residuals, matters: float) -> Blindness | None:
    noise = residuals.solution.noise
    for channel, of_rows, law in (
        ("capture", noise.capture, noise.capture_law),
        ("reference", noise.reference, noise.reference_law),
    ):
        if of_rows is None or law is None or of_rows.weightless:
            continue
        variance = sum(spectrum.variance for spectrum in law.spectra)
        slow = sum(float(spectrum.variances.sum()) for spectrum in law.spectra)
        size = float(np.sqrt(slow / max(len(law.spectra), 1)))
        if slow > COLOURED_SHARE * variance and size > matters:
            return Blindness(
                f"{size:.2g}″ of the residual of the {channel} changes slowly, far more than "
                "single readings scatter: such a slow effect cannot be distinguished from noise",
                "the same measurement once more, in another order and with the temperature "
                "recorded: an error that repeats at the same angle is not noise",
                "again",
            )
    return None


def _residual_unseen(
    residuals: Residuals, residual_rms_arcsec: Mapping[str, float]
) -> Blindness | None:
    """Return a reason if the set would miss most generic effects as large as the residual, else
    None."""
    tried = unseen = 0
    generic = [
        ProductOfParts.of(condition, () if order is None else (order,), frame)
        for condition in _simple(residuals.observations)
        for order in GENERIC_ORDERS
        for frame in _frames(residuals.observations)
    ]
    for effect in generic:
        smallest = smallest_detectable(residuals, effect, {}, float(len(generic)))
        if smallest is None or not smallest.rms_arcsec:
            continue
        tried += 1
        unseen += not any(
            size < residual_rms_arcsec.get(channel, 0.0)
            for channel, size in smallest.rms_arcsec.items()
        )
    if unseen <= UNSEEN_SHARE * tried:
        return None
    return Blindness(
        f"{unseen} of {tried} simple effects would be found only if they were larger than the "
        "whole residual",
        "the same measurement with more rows: more turns, or more visits of each station",
        "turns" if residuals.observations.capture is not None else None,
    )


def _simple(observations: Observations) -> list[Condition]:
    found = conditions(observations)
    return [
        item
        for item in found
        if item.time_constant_s is None
        and item.from_run is None
        and not item.form
        and item is not DIRECTION_TIME
    ]


def _frames(observations: Observations) -> list[Frame]:
    return ["reference"] if observations.capture is None else ["head2"]


__all__ = [
    "Blindness",
    "Coverage",
    "blind_orders",
    "blindness",
    "coverage",
    "effect_or_noise",
]
