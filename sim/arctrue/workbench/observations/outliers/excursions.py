"""Finds values that jump away from the values before them and come back within three rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.observations.outliers.single_rows import MOST_ROWS, NORMAL_MAD

Float = NDArray[np.float64]

FAR_SIGMA = 12.0
"""Least distance of an excursion, in scatters from row to row: a probability of 10⁻³² for any
number of rows."""
SAME_SIZE = 0.5
"""Share within which the jump away and the jump back must agree."""
ENOUGH = 100_000
"""Number of steps, spread over all, from which a scatter is taken."""


def step_scatter(steps: Float) -> float:
    """Return the robust standard deviation of a step that white noise of the rows makes.

    It comes from the differences of steps, so that a slowly changing speed does not count.
    """
    if steps.size < 3:
        return 0.0
    place = np.arange(0, steps.size - 1, max(steps.size // ENOUGH, 1))
    second = steps[place + 1] - steps[place]
    # Noise σ makes √2·σ in a step and √6·σ in a difference of steps.
    return float(NORMAL_MAD * np.median(np.abs(second - np.median(second))) * np.sqrt(2.0 / 6.0))


def excursions(values: Float, least: float) -> list[tuple[int, int, float]]:
    """Return first row, row after the last, and size of every excursion of ``values``, (rows,).

    An excursion is larger than ``least`` and FAR_SIGMA, and ends after MOST_ROWS at most.
    """
    steps = np.diff(values)
    far = np.flatnonzero(np.abs(steps) > max(least, FAR_SIGMA * step_scatter(steps)))
    found: list[tuple[int, int, float]] = []
    end = -1
    for place, after in zip(far[:-1].tolist(), far[1:].tolist(), strict=True):
        there, back = float(steps[place]), float(steps[after])
        opposite = abs(there + back) < SAME_SIZE * max(abs(there), abs(back))
        if place >= end and after - place <= MOST_ROWS and opposite:
            found.append((place + 1, after + 1, there))
            end = after + 1
    return found
