"""Models the entity ``turn_difference``, which computes the difference of two angles the shorter
way round."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def turn_difference(
    minuend: ArrayLike, subtrahend: ArrayLike, counts_per_rev: int
) -> NDArray[np.int64]:
    """Return minuend − subtrahend in counts, modulo one turn, within [−½, ½) of a turn.

    Both arguments are angles within a turn in whole counts; their shapes broadcast.
    """
    straight = np.asarray(minuend, dtype=np.int64) - np.asarray(subtrahend, dtype=np.int64)
    lowest = -(counts_per_rev // 2)
    folded: NDArray[np.int64] = (straight - lowest) % counts_per_rev + lowest
    return folded
