"""Models the entity ``turn_counter``, which counts the turns of an angle."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.generated.number_formats import TURN_NUMBER_WIDTH


def turn_numbers(angle: ArrayLike, counts_per_rev: int, first: int = 0) -> NDArray[np.int64]:
    """Return the turn number of each angle, (angles,); the model omits the latency of the entity.

    ``angle``: counts of consecutive accepted angles, (angles,); the first is in turn ``first``. The
    table is assumed to move the shorter way round from each angle to the next; a step of exactly
    half a turn does not change the turn number. The numbers wrap modulo 2²⁴ like those of the
    gateware.
    """
    step = np.diff(np.asarray(angle, dtype=np.int64))
    wraps = (2 * step < -counts_per_rev).astype(np.int64) - (2 * step > counts_per_rev)
    numbers = np.concatenate([[first], first + np.cumsum(wraps)])
    half = 1 << (TURN_NUMBER_WIDTH - 1)
    wrapped: NDArray[np.int64] = (numbers + half) % (2 * half) - half
    return wrapped
