"""Makes the random draws that several causes share."""

from __future__ import annotations

import cmath

import numpy as np

from arctrue.table.declaration import Occasion, Random


def angle(random: Random) -> float:
    """Draw an angle from 0 to a full turn, radians."""
    return float(random.uniform(0.0, 2 * np.pi))


def sign(random: Random) -> float:
    """Draw −1 or +1."""
    return float(random.choice([-1.0, 1.0]))


def log_uniform(low: float, high: float, random: Random) -> float:
    """Draw a number between two limits, uniform in its logarithm."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


def vector(size: float, random: Random) -> complex:
    """Draw a vector of a given length, x + jy, in a random direction."""
    return cmath.rect(size, angle(random))


def any_head(random: Random, occasion: Occasion) -> int:
    """Draw one of the heads, numbered from 0."""
    return int(random.integers(len(occasion.heads)))


def later_head(random: Random, occasion: Occasion) -> int:
    """Return head 2 of two heads, because their difference does not show which of them has the
    fault; draw one of three or four heads. Heads are numbered from 0."""
    return 1 if len(occasion.heads) == 2 else any_head(random, occasion)


def instants(mean_s: float, random: Random, occasion: Occasion) -> tuple[float, ...]:
    """Draw irregular instants, which usually begin before the first run and end after the last
    run."""
    number = 3 + int(1.5 * occasion.end_s / mean_s)
    waits_s = random.gamma(4.0, mean_s / 4.0, number)
    drawn = np.cumsum(waits_s) - 2.0 * mean_s
    beyond = int(np.searchsorted(drawn, occasion.end_s)) + 2
    return tuple(drawn[:beyond].tolist())
