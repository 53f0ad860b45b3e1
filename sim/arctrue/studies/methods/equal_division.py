"""Calibrates by the equal division average (EDA): compares head 1 with the mean of N heads at equal
distances.

The mean of N readings contains only those errors of the disc whose orders are multiples of N, and
no radial motion of the axis (N ≥ 2). Head 1 minus the mean is therefore the error of head 1, except
for the orders that are multiples of N.
"""

from __future__ import annotations

import numpy as np

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.studies.methods.method import Method, of_harmonics
from arctrue.studies.methods.normal_equations import NormalEquations
from arctrue.studies.methods.world import TURN_RAD, Output, World


def _run(world: World, heads: int) -> Output:
    places = [-TURN_RAD * k / heads for k in range(heads)]
    seen = world.settings.orders[world.settings.orders % heads != 0]
    sums = NormalEquations(2 * seen.size + 1)
    for counts in world.turns(places):
        reading = counts * world.count_rad
        difference = (counts[0] - counts.mean(axis=0)) * (world.count_rad * ARCSEC_PER_RAD)
        phase = np.multiply.outer(reading[0], seen.astype(np.float64))
        sums.add(
            np.hstack([np.cos(phase), np.sin(phase), np.ones((phase.shape[0], 1))]), difference
        )
    return of_harmonics(seen, sums.solved()[:-1])


def equal_division(heads: int) -> Method:
    """Return the method of equal division with ``heads`` heads."""
    return Method(
        f"equal_division_{heads}",
        f"Equal division, {heads} heads (EDA)",
        "Watanabe et al. [5]; [18–21]",
        heads,
        f"{heads} heads spaced by {360 / heads:g}°",
        f"orders {heads}, {2 * heads}, {3 * heads}, …",
        lambda world: _run(world, heads),
    )
