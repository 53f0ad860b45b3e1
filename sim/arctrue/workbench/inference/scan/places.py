"""Places of a scan and their exact gains."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.score_test import Score

Float = NDArray[np.float64]

BEST_PLACES = 4
"""Number of places of a coarse scan that are scored exactly."""
LINES = frozenset({"frequency", "line", "unwrapped_order"})
"""Kinds of search for a wave of any order or frequency, not only of whole orders."""
LEAST_OWN = 0.05
"""Smallest share of a line's weighted squares that the model of whole orders must leave. In one run
of T turns this share is 1 − sinc²(δT), where δ is the distance from a whole order, so that a line
is found only at a distance of 1/(8T) or more.
"""


@dataclass(frozen=True, slots=True)
class Place:
    """Search parameters that were found, and the number of independent places that were tried."""

    nonlinear: dict[str, float]
    gain: float
    """Weighted sum of squares that the columns remove from the residuals, 2·Δ(log likelihood)."""
    trials: float


def scored(
    effect: Effect, residuals: Residuals, places: Iterable[dict[str, float]], trials: float
) -> list[Place]:
    """Return the exact gain of each place within the declared ranges, best first."""
    ranges = {item.name: effect.search_range(item.name) for item in effect.search}
    tried = [
        place
        for place in places
        if all(ranges[name][0] <= value <= ranges[name][1] for name, value in place.items())
    ]
    scores = residuals.scores([(effect, place) for place in tried])
    found = [
        Place(place, gain_of_its_own(effect, score), max(trials, 1.0))
        for place, score in zip(tried, scores, strict=True)
    ]
    return sorted(found, key=lambda candidate: -candidate.gain)


def gain_of_its_own(effect: Effect, score: Score) -> float:
    """Return the gain, or 0 for a line that the model explains almost completely.

    Next to one of the model's own orders, such a line describes a slow change of this order, and
    its size has no meaning.
    """
    return score.gain if effect.search_kind not in LINES or score.own_share > LEAST_OWN else 0.0


def peaks(power: Float, count: int) -> NDArray[np.int64]:
    """Return the indices of the highest local maxima, highest first."""
    if power.size == 0:
        return np.zeros(0, dtype=np.int64)
    padded = np.concatenate([[-np.inf], power, [-np.inf]])
    top = (padded[1:-1] >= padded[:-2]) & (padded[1:-1] >= padded[2:])
    places = np.flatnonzero(top)
    return places[np.argsort(power[places])[::-1][:count]]
