"""Makes a model for a set with only a reference run, with the orders that its stations can
separate."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.observations import Observations, ReferenceRows

MOST_ORDER = 20
"""Highest order of the model; it equals the highest order of the default model."""
LEAST_ORDER = 2
"""Smallest allowed value of the highest order: a correction needs eccentricity and ovality."""


def model_of_stations(rows: ReferenceRows, most_order: int = MOST_ORDER) -> Model:
    """Make a model of harmonics 1 to N of the turn; half a wave of order N is longer than each gap.

    A gap is the distance of two neighbouring stations. At evenly spaced stations, two orders are
    aliases if their sum is the number of stations. Orders above N could take any value between the
    stations. ``most_order``: upper limit of N. Raises ValueError if a gap makes N less than
    LEAST_ORDER.
    """
    gap = _largest_gap_deg(rows.target_rad)
    most = min(math.ceil(180.0 / gap - 1e-6) - 1, MOST_ORDER)
    if most < LEAST_ORDER:
        raise ValueError(
            f"the reference run has no target over {gap:.1f}° of the turn, and the set has no "
            f"capture: expected targets less than {180.0 / LEAST_ORDER:g}° apart all "
            "around; measure the rest of the turn, or give a model with --model"
        )
    return Model(
        [ModelEffect("graduation_harmonics", {"orders": list(range(1, min(most, most_order) + 1))})]
    )


def require_whole_turn(observations: Observations) -> None:
    """Raise ValueError if the rows of a set leave a gap in the turn as long as half a wave of order
    MOST_ORDER, the highest order of the default model; this order could take any value in the gap.
    """
    rows = [
        part.angle_rad
        for part in (observations.capture, observations.every_reference_row)
        if part is not None
    ]
    gap = _largest_gap_deg(np.concatenate(rows))
    if gap >= 180.0 / MOST_ORDER:
        raise ValueError(
            f"the set has no row over {gap:.1f}° of the turn: expected rows less than "
            f"{180.0 / MOST_ORDER:g}° apart all around; capture a whole turn, or take the capture "
            "out of the set, or give a model with --model"
        )


def _largest_gap_deg(angle_rad: NDArray[np.float64]) -> float:
    angles = np.unique(np.round(np.degrees(angle_rad) % 360.0, 6))
    return float(np.diff(np.append(angles, angles[0] + 360.0)).max())
