"""Finds how far a reference run has moved since the last reversal of its direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Integer = NDArray[np.int64]


DECIMALS = 9
"""Decimals of a travel in radians, 0.2 milliarcseconds: sums of equal steps then are equal."""


def since_reversal(
    target_rad: Float, direction: NDArray[np.generic]
) -> tuple[Integer, Float, NDArray[np.bool_]]:
    """Return for each row the number of reversals before it, the travel of the targets since the
    last reversal, and whether this travel is less than the shortest travel from any reversal to
    the second place after it.

    The travel is in radians; before the first reversal, it starts at the first row.

    A step between neighbouring rows counts as the shorter way round the turn, so that targets of 0°
    to 360° may start again at 0°. The way beyond the last target before a reversal is not in the
    rows and does not count.
    """
    way = direction.astype(np.float64)
    turned = np.diff(way, prepend=way[:1]) != 0.0
    reversals = np.cumsum(turned).astype(np.int64)
    step = np.diff(target_rad, prepend=target_rad[:1])
    along = np.cumsum((np.mod(step + np.pi, 2.0 * np.pi) - np.pi) * way)
    first = np.flatnonzero(np.diff(reversals, prepend=-1) > 0)
    # The travel to the first row after a reversal belongs to the new direction.
    start = np.concatenate([along[:1], along[first[1:] - 1]])
    travel = np.maximum(along - start[reversals], 0.0)
    # A row behind the farthest row since the reversal does not show a motion back: its target is
    # noisy.
    above = np.ceil(travel.max(initial=0.0)) + 1.0
    travel = np.maximum.accumulate(travel + above * reversals) - above * reversals
    travel = np.round(travel, DECIMALS)
    moved = (reversals > 0) & (travel > travel[first][reversals])
    return reversals, travel, travel < np.min(travel, where=moved, initial=np.inf)
