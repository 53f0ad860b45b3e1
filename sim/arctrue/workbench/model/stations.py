"""Makes a model for a set with only a reference run, with the orders that its stations can
separate."""

from __future__ import annotations

import math

import numpy as np

from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.observations import ReferenceRows

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
    station = np.unique(np.round(np.degrees(rows.target_rad) % 360.0, 6))
    gap = float(np.diff(np.append(station, station[0] + 360.0)).max())
    most = min(math.ceil(180.0 / gap - 1e-6) - 1, MOST_ORDER)
    if most < LEAST_ORDER:
        raise ValueError(
            f"the reference run has no target over {gap:.1f}° of the turn, and the set has no "
            f"capture: expected targets no more than {180.0 / (LEAST_ORDER + 1):g}° apart all "
            "around; measure the rest of the turn, or give a model with --model"
        )
    return Model(
        [ModelEffect("graduation_harmonics", {"orders": list(range(1, min(most, most_order) + 1))})]
    )
