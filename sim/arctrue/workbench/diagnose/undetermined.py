"""Detects a model that the rows of a reference do not determine, and states the measurement that
would determine it."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.inference.design_matrix import measured_arcsec
from arctrue.workbench.inference.solution import Solution

MOST_LEFT = 2.0
"""Largest ratio of the residual variance to the measured variance. Var(y) = Var(model) +
Var(residual) + 2·cov. A residual variance above the measured variance shows that the model has
added error; at twice the measured variance, it has added as much as was measured."""
WHOLE_TURN_DEG = 355.0
"""Smallest arc that counts as a whole turn; for such an arc, the sentence does not state the
arc."""
WHOLE_TURNS = "a reference over whole turns, or a model of fewer orders"
"""Next measurement if the rows do not determine the model."""


def undetermined(solution: Solution) -> str | None:
    """Return the reason why no statement can rest on this model.

    Return None if the rows determine the model, or if the set has a capture. Orders that a part of
    a turn does not separate become as large as the noise allows and cancel each other. A further
    sine, or slow noise, then only cancels the error that these orders have added.
    """
    rows = solution.observations.reference
    left = solution.reference_residual_arcsec()
    if rows is None or left is None or solution.observations.capture is not None:
        return None
    measured = measured_arcsec(solution.observations, capture=False)
    if float(np.var(left)) <= MOST_LEFT * float(np.var(measured)):
        return None
    arc_deg = float(np.degrees(np.ptp(rows.target_rad)))
    over = f" over {arc_deg:.0f}°" if arc_deg < WHOLE_TURN_DEG else ""
    return (
        f"the rows{over} do not determine the model: it leaves {float(np.std(left)):.3g}″ RMS "
        f"where {float(np.std(measured)):.3g}″ were measured, and a further finding may only "
        "cancel its orders"
    )
