"""Makes one set of the independent generator (this package) from its world, content and seed."""

from __future__ import annotations

from typing import Any

import numpy as np

from arctrue.measurement import MeasurementSet
from arctrue.studies.benchmark.independent.scene import made
from arctrue.studies.benchmark.independent.world import HIDDEN, independent_worlds


def independent_set(
    world: str, content: str, seed: int, samples: int
) -> tuple[MeasurementSet, dict[str, Any]]:
    """Make the measurement set and its truth.

    ``samples``: the largest number of rows in a run or a log. Raises KeyError for an unknown world,
    ValueError for a content that the world does not have.
    """
    chosen = independent_worlds()[world]
    if content not in chosen.contents:
        raise ValueError(f"{world} has the contents {', '.join(chosen.contents)}, not {content}")
    random = np.random.default_rng([seed, 1])
    return made(chosen.draw(random, content == HIDDEN, samples), random)
