"""Forecasts the day on which the size of an effect passes its limit, with an interval.

The values follow a constant and the changes that were found. The last change continues: a step
stays, a drift slows down, keeps its rate or speeds up. A draw of the posterior consists of kind,
place and course of the last change, of all coefficients, and of the variance. Each draw gives a
day, which is infinite if the limit is never passed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.metrology.life.change import (
    Change,
    Place,
    Random,
    Shape,
    design_of,
    weighted_rss,
    weights,
)
from arctrue.metrology.life.series import Series

Float = NDArray[np.float64]

DRAWS = 1_000
"""Number of draws of the posterior; about 25 draws lie below the interval, and about 25 above
it."""
GRID = 160
"""Number of future days for which the size is computed; each day is 7 % farther away than the
previous one."""
NEAREST_DAYS = 1.0
LEVEL = 0.95
FARTHEST_DAYS = 36_525.0
"""Largest number of days ahead, a hundred years; a later day counts as infinite."""


@dataclass(frozen=True, eq=False)
class Forecast:
    """Forecast of the day on which a limit is passed. Days count from 1970; an infinite day means
    never."""

    series: Series
    limit: float
    changed: bool
    """Whether a change was found; without a change the size stays constant."""
    earliest_day: float
    """Day before which 2.5 % of the draws have passed the limit."""
    day: float
    """Median of the draws' days."""
    latest_day: float
    """Day before which 97.5 % of the draws have passed the limit."""
    passing_days: Float
    """Day on which each draw passes the limit, (draws,), ascending; infinite if a draw never
    does."""

    def probability(self, day: float) -> float:
        """Return the probability that the limit is passed on or before ``day``."""
        return float(np.searchsorted(self.passing_days, day, side="right")) / DRAWS

    @property
    def passed(self) -> bool:
        """Whether the limit is already passed, with a probability above one half."""
        return self.probability(float(self.series.days[-1])) > 0.5

    def alarm(self, horizon_days: float) -> bool:
        """Tell whether the limit is passed, or a change may lead to it within ``horizon_days``.

        A change may lead to the limit if the earlier end of the forecast's interval lies within the
        horizon.
        """
        within = self.earliest_day <= float(self.series.days[-1]) + horizon_days
        return self.passed or (self.changed and within)


def forecast(series: Series, changes: Sequence[Change], limit: float, random: Random) -> Forecast:
    """Forecast the day on which the size of ``series`` passes ``limit``, in the unit of the series.

    ``changes``: the changes of this series in the order in which they were found.
    """
    known: list[Shape] = []
    likely: tuple[Place, ...] = ()
    for number, change in enumerate(changes):
        best = max(change.places, key=lambda place: place.probability)
        if number == len(changes) - 1:
            likely = change.places
        else:
            known.append(best.shape)
    share = np.array([place.probability for place in likely])
    drawn = random.multinomial(DRAWS, share / share.sum()) if likely else np.array([DRAWS])
    days: list[Float] = []
    for place, number in enumerate(drawn):
        if number:
            last = [likely[place].shape] if likely else []
            days.append(_days_of(series, [*known, *last], limit, int(number), random))
    found = np.sort(np.concatenate(days))
    tail = 0.5 * (1.0 - LEVEL)
    at = [int(tail * DRAWS), DRAWS // 2, int((1.0 - tail) * DRAWS) - 1]
    low, middle, high = (float(found[index]) for index in at)
    return Forecast(series, limit, bool(changes), low, middle, high, found)


def _days_of(
    series: Series, known: Sequence[Shape], limit: float, number: int, random: Random
) -> Float:
    """Return the days, (number,), on which ``number`` draws of one combination of changes pass the
    limit."""
    days, values = series.days, series.values
    design = design_of(days, known)
    weight = weights(values, series.u, design)
    root = np.sqrt(weight)[:, None]
    mean, *_ = np.linalg.lstsq(root * design, root * values, rcond=None)
    parts = values.shape[1]
    freedom = max((days.size - design.shape[1]) * parts, 1)
    # Draws of the variance of a value with weight 1. Its estimate is at least 1, the variance if
    # only u contributes.
    square = max(weighted_rss(values, weight, design), float(freedom)) / random.chisquare(
        freedom, number
    )
    half = np.linalg.cholesky(
        np.linalg.pinv((root * design).T @ (root * design)) + 1e-18 * np.eye(design.shape[1])
    )
    noise = random.standard_normal((number, design.shape[1], parts))
    drawn = mean + np.sqrt(square)[:, None, None] * np.einsum("ij,njd->nid", half, noise)
    ahead = np.concatenate(([0.0], np.geomspace(NEAREST_DAYS, FARTHEST_DAYS, GRID)))
    shapes = np.ones((ahead.size, len(known) + 1))
    for column, (kind, index, exponent) in enumerate(known, start=1):
        if kind == "drift":
            whole = days[-1] - days[index]
            shapes[:, column] = ((whole + ahead) / whole) ** exponent
    square_size = np.zeros((number, ahead.size))
    for part in range(parts):
        square_size += (drawn[:, :, part] @ shapes.T) ** 2
    return np.asarray(days[-1] + _first_passing(ahead, np.sqrt(square_size), limit))


def _first_passing(ahead: Float, size: Float, limit: float) -> Float:
    """Return the time at which each course, (draws, grid), first reaches the limit.

    Courses are linear between the points of the grid. The time is 0 for a course that starts above
    the limit, and infinite for a course that never reaches it.
    """
    above = size >= limit
    first = above.argmax(axis=1)
    never, row = ~above.any(axis=1), np.arange(first.size)
    before = np.maximum(first - 1, 0)
    low, high = size[row, before], size[row, first]
    share = np.where(first > 0, (limit - low) / np.where(high > low, high - low, 1.0), 0.0)
    found = ahead[before] + share * (ahead[first] - ahead[before])
    return np.asarray(np.where(never, np.inf, found))
