"""Computes the curves that orders of the turn can form on a short arc."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.numeric.harmonics import harmonic_columns

Float = NDArray[np.float64]

LEAST_SIZE = 1e-4
"""Smallest RMS on the arc of a curve that is kept, as a share of the RMS of its orders over whole
turns. The largest plausible eccentricity, 150″, forms at most 0.01″ of an omitted curve."""
POINTS = 1000
"""Number of points of the arc at which the curves are calculated; 50 for each wave of order 20 in a
turn."""


def arc_curves(
    angle_rad: Float, orders: tuple[int, ...], start_deg: float, length_deg: float
) -> Float:
    """Return orthogonal curves of these orders on an arc, (rows, curves).

    The curves are the principal components of the orders on the arc down to LEAST_SIZE. On the arc
    each curve has the mean 0 and the RMS 1. Outside the arc it keeps its value at the nearest end.
    """
    start, length = np.radians(start_deg), np.radians(length_deg)
    middle = start + 0.5 * length
    inside = np.mod(angle_rad - middle + np.pi, 2.0 * np.pi) - np.pi
    factors, means = _components(orders, float(length))
    columns = harmonic_columns(np.clip(inside, -0.5 * length, 0.5 * length), orders)
    return np.asarray(columns @ factors - means, dtype=np.float64)


@lru_cache(maxsize=8)
def _components(orders: tuple[int, ...], length_rad: float) -> tuple[Float, Float]:
    """Return the factors of the orders' columns in each curve, and the means of the curves."""
    columns = harmonic_columns(np.linspace(-0.5, 0.5, POINTS) * length_rad, orders)
    means = columns.mean(axis=0)
    _, values, vectors = np.linalg.svd(columns - means, full_matrices=False)
    # Over whole turns each value is √(POINTS/2).
    kept = values >= LEAST_SIZE * np.sqrt(0.5 * POINTS)
    factors = vectors[kept].T / values[kept] * np.sqrt(POINTS)
    # The sign of an eigenvector is arbitrary: each curve ends above 0.
    factors = factors * np.where((columns[-1] - means) @ factors < 0.0, -1.0, 1.0)
    return factors, means @ factors
