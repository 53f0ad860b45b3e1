"""The model that a reference run alone determines: no more orders than its stations tell apart."""

from __future__ import annotations

import math

import numpy as np

from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.observations import ReferenceRows

MOST_ORDER = 20
"""As many as the default model has."""
LEAST_ORDER = 2
"""Fewer make no correction: eccentricity and ovality are the least of a table."""


def model_of_stations(rows: ReferenceRows) -> Model:
    """Harmonics 1 to N of the turn, N the highest order below half a wave a gap.

    Two orders whose sum is the number of even stations look alike there; above N the stations
    cannot tell what is between them. Raises ValueError where a gap leaves fewer than LEAST_ORDER.
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
    return Model([ModelEffect("graduation_harmonics", {"orders": list(range(1, most + 1))})])
