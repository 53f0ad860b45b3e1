"""Simulates sets of a table whose reversal error a polygon measures, from the definition of the
error."""

from __future__ import annotations

import numpy as np

from arctrue.measurement import MeasurementSet, Reference, Table

REVERSAL = 100.0
VARIES = 0.2


def reversal_set(
    seed: int = 1,
    *,
    stations: int = 36,
    cycles: int = 5,
    varies: float = VARIES,
    noise: float = 0.05,
) -> MeasurementSet:
    """Return a set that goes up and down over the same stations, with a reversal error.

    Half of the error acts in each direction. The error at each station is multiplied by a random
    factor with the standard deviation ``varies``.
    """
    random = np.random.default_rng(seed)
    up = np.arange(stations) * 360.0 / stations
    target = np.tile(np.concatenate([up, up[::-1]]), cycles)
    direction = np.tile(np.repeat([1, -1], stations), cycles)
    angle = np.radians(target)
    factor = random.normal(size=stations)
    factor = 1.0 + varies * (factor - factor.mean()) / factor.std()
    place = np.round(target * stations / 360.0).astype(int) % stations
    error = 40.0 * np.cos(angle + 0.4) + 8.0 * np.cos(2.0 * angle - 1.0)
    error = error + 0.5 * REVERSAL * direction * factor[place]
    reference = Reference(
        target,
        error + random.normal(0.0, noise, target.size),
        run=np.zeros(target.size, dtype=np.int64),
        time_s=np.arange(target.size) * 5.0,
        cycle=np.repeat(np.arange(cycles), 2 * stations),
        direction=direction,
    )
    return MeasurementSet(Table(), None, reference, title="reversal")
