"""Tells lines in single rows from an oscillation that noise drives.

The ordinates of the spectrum around the lines have an exponential distribution, and their density
is their expectation (P. Whittle, J. Roy. Stat. Soc. B 15 (1953) 125). With the lines in the model
the density is even; without them, it is even except for a peak of the width of an oscillation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

REACH = 40
"""Number of ordinates on each side of the lines, 1/span apart: as many together as those of the
median that gives the local level, doubled."""
COHERENT = 0.25 * 0.5 ** np.arange(7)
"""Decay times of the oscillation, in spans: the longest is a quarter of the record, as in the
search for lines; that of the shortest, 1/256, is wider than the ordinates."""
BLOCKS_A_RATE = 16
"""Number of blocks in which rows are summed, for each ordinate: the sum over a block keeps at least
sinc² 1/32 = 99.7 % of the power."""
BETWEEN = np.linspace(-1.0, 1.0, 9)
"""Places of the oscillation's peak relative to the highest ordinate, in ordinates."""
HEIGHTS = 40
"""Number of heights of the peak that are tried, each at most twice the one before up to a power of
10¹¹ times the level."""
LEAST_HEIGHT = 0.1
"""Lowest height of the peak that is tried, as a share of the level."""


def gain_over_an_oscillation(
    place: Float, senses: Float, left_arcsec: Float, without_arcsec: Float, rates: Sequence[float]
) -> float:
    """Return the log likelihood that lines gain over one oscillation in their place.

    ``left_arcsec``: residual with these lines in the model; ``without_arcsec``: residual without
    them, (rows,). ``senses``: zeros and ones for each sense of motion, (rows, 1 or 2). ``rates``:
    rates of the lines, which are neighbours.
    """
    span = float(np.ptp(place))
    middle = 0.5 * (min(rates) + max(rates))
    reach = REACH + int(np.ceil(0.5 * (max(rates) - min(rates)) * span))
    remaining, power = (
        _ordinates(place, senses, values, middle, reach) for values in (left_arcsec, without_arcsec)
    )
    freedom = senses.shape[1]
    level = max(float(remaining.mean()) / freedom, 1e-300)
    with_lines = -freedom * remaining.size * (float(np.log(level)) + 1.0)
    return float(with_lines - _of_an_oscillation(power, freedom, reach))


def _ordinates(place: Float, senses: Float, values: Float, middle: float, reach: int) -> Float:
    """Return the power at ``middle`` and at ``reach`` rates on each side of it, 1/span apart; the
    sum over the senses of motion."""
    span, start = float(np.ptp(place)), float(place.min())
    blocks = BLOCKS_A_RATE * 2 * reach
    block = np.minimum(((place - start) * (blocks / span)).astype(np.int64), blocks - 1)
    turned = values * np.exp(-2j * np.pi * middle * (place - start))
    number = np.arange(-reach, reach + 1)
    waves = np.exp(-2j * np.pi * np.outer(number, (np.arange(blocks) + 0.5) / blocks))
    power = np.zeros(number.size)
    for sense in senses.T:
        own = turned * sense
        sums = np.bincount(block, own.real, blocks) + 1j * np.bincount(block, own.imag, blocks)
        power += np.abs(waves @ sums) ** 2 / max(float(sense.sum()), 1.0)
    return power


def _of_an_oscillation(power: Float, freedom: int, reach: int) -> float:
    """Return the largest log likelihood of the ordinates with an even level and one peak."""
    number = np.arange(-reach, reach + 1)
    top = number[int(np.argmax(power))]
    highest = float(power.max()) / max(float(np.median(power)), 1e-300)
    heights = np.geomspace(LEAST_HEIGHT, max(10.0 * highest, 1.0), HEIGHTS)[:, np.newaxis]
    best = -np.inf
    for decay in COHERENT:
        for between in BETWEEN:
            shape = 1.0 + heights * _peak(number - top - between, float(decay))
            level = np.mean(power / shape, axis=1) / freedom
            found = -freedom * (power.size * (np.log(level) + 1.0) + np.log(shape).sum(axis=1))
            best = max(best, float(found.max()))
    return best


def _peak(away: Float, decay: float) -> Float:
    """Return the expected power of an oscillation, as a share of that at its frequency; ``away``:
    distance from its frequency in ordinates, ``decay``: decay time in spans.

    It is the transform of the covariance e^{−|u|/decay} times 1 − |u|, 0 ≤ |u| ≤ 1, u in spans.
    """

    def transform(at: Float) -> Float:
        rate = 1.0 / decay + 2j * np.pi * at
        return np.asarray((1.0 / rate - (1.0 - np.exp(-rate)) / rate**2).real)

    return transform(away) / transform(np.zeros(1))
