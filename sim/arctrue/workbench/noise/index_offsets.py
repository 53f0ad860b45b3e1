"""Estimates how far the index marks scatter the offsets of runs: as stated, and as a set shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.noise.noise import INDEX_FREEDOM
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]

STATED_INDEX_FREEDOM = 60.0
"""How many runs a repeatability is worth that the set states."""


def index_variance(observations: Observations, offsets: Float) -> tuple[float, float]:
    """Variance of a run's offset (arcsec²), and how many runs the knowledge beforehand is worth.

    The mean of a scaled inverse χ²: ±1 count a head, or what the set states, weighs like so many
    runs; the offsets of the set's own runs are added.
    """
    stated = getattr(observations, "index_repeatability_counts", None) is not None
    freedom = STATED_INDEX_FREEDOM if stated else INDEX_FREEDOM
    prior = observations.index_sigma_arcsec**2
    total = freedom * prior + float(offsets @ offsets)
    return total / (freedom + offsets.size), freedom
