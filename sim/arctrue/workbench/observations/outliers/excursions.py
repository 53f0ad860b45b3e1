"""Finds values that jump away from the values before them and come back within three rows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.observations.outliers.far_rows import MOST_ROWS, NORMAL_MAD

Float = NDArray[np.float64]

FAR_SIGMA = 12.0
"""Smallest size of an excursion, in standard deviations of a step: white noise exceeds it with a
probability of 4·10⁻³³ per step.
"""
SAME_SIZE = 0.5
"""Largest difference of the jump away and the jump back, as a share of the larger jump."""
ENOUGH = 100_000
"""The scatter of a longer record is calculated from evenly spread steps; their number is at least
this value and less than twice this value."""


def step_scatter(steps: Float) -> float:
    """Return the robust standard deviation of the steps that white noise of the rows causes.

    The standard deviation is calculated from the differences of steps, so that a slowly changing
    speed does not contribute.
    """
    if steps.size < 3:
        return 0.0
    place = np.arange(0, steps.size - 1, max(steps.size // ENOUGH, 1))
    second = steps[place + 1] - steps[place]
    # Noise with the standard deviation σ causes √2·σ in a step and √6·σ in a difference of steps.
    return float(NORMAL_MAD * np.median(np.abs(second - np.median(second))) * np.sqrt(2.0 / 6.0))


def excursions(values: Float, least: float) -> list[tuple[int, int, float]]:
    """Return first row, row after the last, and size of every excursion of ``values``, (rows,).

    Both steps of an excursion are larger than ``least`` and than FAR_SIGMA standard deviations of a
    step; it lasts at most MOST_ROWS rows.
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
