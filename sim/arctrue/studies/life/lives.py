"""Simulates lives: the size of an effect over two years, measured every other week."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.metrology.life.series import Series

Float = NDArray[np.float64]
Random = np.random.Generator

YEARS_DAYS = 730.0
BETWEEN_DAYS = 14.0
JITTER_DAYS = 3.0
"""Largest difference between the day of a measurement and its planned day."""
MISSED = 0.1
"""Share of the planned sets that are not measured."""
LIMIT_ARCSEC = 1.0
FIRST_SIZE_ARCSEC = 0.2
"""Largest size of the effect at the beginning of a life."""
U_ARCSEC = 0.03
"""Typical standard uncertainty of a fitted size; the uncertainty in one set is 0.7 to 1.5 times
this value."""
SCATTER_ARCSEC = 0.05
"""Standard deviation of the true size between sets, due to mounting and temperature."""
STEP_DAYS = 0.25
"""Step of the grid of days on which the day of the limit is searched."""

Course = NDArray[np.float64]
"""Change of the size at each day of a grid, in units of the limit, (days,)."""


@dataclass(frozen=True, eq=False)
class Life:
    """Measurements of a simulated life, and the true days of damage and limit."""

    kind: str
    series: Series
    onset_day: float
    """Day on which the damage begins; infinite if it never begins."""
    limit_day: float
    """Day on which the true size exceeds the limit; infinite if the size stays within the limit for
    the whole life."""


def wearing_bearing(days: Float, begin: float, random: Random) -> Course:
    """Simulate wear that grows with a power of the time since it began; the power is between 1 and
    2."""
    whole, power = random.uniform(120.0, 400.0), random.uniform(1.0, 2.0)
    return np.asarray((np.maximum(days - begin, 0.0) / whole) ** power)


def loosening_bracket(days: Float, begin: float, random: Random) -> Course:
    """Simulate knocks at irregular instants, every 25 days on average; each adds a little play."""
    knocks = begin + np.cumsum(random.exponential(25.0, 60))
    play = random.uniform(0.05, 0.15, 60)
    return np.asarray((days[:, None] >= knocks) @ play)


def creeping_clamp(days: Float, begin: float, random: Random) -> Course:
    """Simulate creep of a bolted joint, which grows with the logarithm of time; after 200 to 400
    days it equals the limit.
    """
    constant = random.uniform(30.0, 120.0)
    whole = random.uniform(200.0, 400.0)
    elapsed = np.maximum(days - begin, 0.0)
    return np.asarray(np.log1p(elapsed / constant) / np.log1p(whole / constant))


def settled_clamp(days: Float, begin: float, random: Random) -> Course:
    """Simulate creep that ends at 0.2 to 0.5 of the limit, so that every alarm is false."""
    end, constant = random.uniform(0.2, 0.5), random.uniform(20.0, 80.0)
    return np.asarray(end * -np.expm1(-np.maximum(days - begin, 0.0) / constant))


def healthy(days: Float, begin: float, random: Random) -> Course:
    """Simulate an effect whose size does not change."""
    return np.zeros(days.size)


KINDS: dict[str, Callable[[Float, float, Random], Course]] = {
    "bearing that wears": wearing_bearing,
    "bracket that loosens": loosening_bracket,
    "clamp that creeps": creeping_clamp,
    "clamp that settles below the limit": settled_clamp,
    "healthy machine": healthy,
}


def simulated_life(kind: str, seed: int) -> Life:
    """Simulate a life of one kind; the size has two components (cosine and sine) for a bearing, one
    component with a sign for every other kind."""
    random = np.random.default_rng([seed, list(KINDS).index(kind)])
    parts = 2 if kind == "bearing that wears" else 1
    begin = float(random.uniform(100.0, 300.0))
    grid = np.arange(0.0, YEARS_DAYS, STEP_DAYS)
    course = KINDS[kind](grid, begin, random) * LIMIT_ARCSEC
    towards = _direction(parts, random)
    first = _direction(parts, random) * random.uniform(0.0, FIRST_SIZE_ARCSEC)
    size = np.linalg.norm(first + course[:, None] * towards, axis=1)
    passed = np.flatnonzero(size >= LIMIT_ARCSEC)
    planned = np.arange(0.0, YEARS_DAYS, BETWEEN_DAYS)
    days = planned + random.uniform(-JITTER_DAYS, JITTER_DAYS, planned.size)
    days = days[random.random(days.size) > MISSED]
    u = U_ARCSEC * random.uniform(0.7, 1.5, days.size)
    values = first + np.interp(days, grid, course)[:, None] * towards
    values = values + SCATTER_ARCSEC * random.standard_normal(values.shape)
    values = values + u[:, None] * random.standard_normal(values.shape)
    return Life(
        kind,
        Series("effect.size", "arcsec", days, values, u),
        begin if KINDS[kind] is not healthy else np.inf,
        float(grid[passed[0]]) if passed.size else np.inf,
    )


def _direction(parts: int, random: Random) -> Float:
    angle = random.uniform(0.0, 2.0 * np.pi)
    if parts == 2:
        return np.array([np.cos(angle), np.sin(angle)])
    return np.array([1.0 if angle < np.pi else -1.0])
