"""Finds an error of the turn that steps at one angle and returns evenly over the turn, such as that
of the joint of a tape round a drum.

Where the model removes the low orders, such a saw tooth leaves a ripple next to its step, whose
largest value looks like the error of a single place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

WIDEST_GAP_TURNS = 0.1
"""Largest gap between neighbouring places of a whole turn, in turns: with a larger gap, the angle
of a step would not be known."""
LEAST_OWN = 0.1
"""Smallest information about a step, in visits of a place: with less, the model explains the
step."""


@dataclass(frozen=True, eq=False)
class StepOfAngle:
    """The step that explains most of the means of the places."""

    angle_rad: float
    size: float
    """Error after the step minus error before it, in the direction of increasing angle."""
    gain: float
    """Sum of squares that the step explains."""
    information: float
    """Information about the size: the gain is size²·information."""
    error: Float
    """Error of each place, (places,)."""
    tried: int
    """Number of angles that were tried."""


def best_step(
    angle_rad: Float,
    crossed: NDArray[np.bool_],
    normal: Float,
    moment: Float,
    *,
    within_a_place: bool,
) -> StepOfAngle | None:
    """Return the step at the best angle; None if the places do not cover the turn.

    ``angle_rad``: increasing angles of the places, (places,); ``crossed``: whether a run goes on
    from each place to the next. Where every run begins or ends, a step would be the error of the
    travel from the first to the last place. ``normal`` and ``moment``: normal matrix and moment of
    the errors of the places, with the model projected out. ``within_a_place``: whether a step may
    also be in the middle of a place, which covers several rows.
    """
    turns = angle_rad / (2.0 * np.pi)
    gaps = np.diff(turns, append=turns[0] + 1.0)
    if turns.size < 2 or gaps.min() <= 0.0 or gaps.max() > WIDEST_GAP_TURNS:
        return None
    at = turns + 0.5 * gaps
    known = crossed
    if within_a_place:
        at = np.concatenate([at, turns])
        known = np.concatenate([crossed, crossed & np.roll(crossed, 1)])
    # From one row after the step to the row before it, one turn later, the error falls by the
    # step's size, so that the step itself is a rise by this size.
    after = np.mod(turns[:, np.newaxis] - at, 1.0)
    after[after == 0.0] = 0.5
    columns = 0.5 - after
    information = np.sum(columns * (normal @ columns), axis=0)
    # The diagonal, without the model, is the number of visits.
    least = LEAST_OWN * float(np.diag(normal).mean())
    gains = np.where(known & (information > least), (moment @ columns) ** 2, 0.0)
    gains /= np.maximum(information, least)
    best = int(np.argmax(gains))
    if gains[best] <= 0.0:
        return None
    size = float(moment @ columns[:, best] / information[best])
    return StepOfAngle(
        float(2.0 * np.pi * np.mod(at[best], 1.0)),
        size,
        float(gains[best]),
        float(information[best]),
        size * columns[:, best],
        at.size,
    )
