"""The table stops at an angle that depends on the direction of approach."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Columns, ConditionedLane, FitContext, Lane, Nonlinear
from arctrue.workbench.effects.scalar_effect import ScalarEffect
from arctrue.workbench.observations import Observations, ReferenceRows

LEAST_REVERSALS = 2
"""Smallest number of reversals. With one reversal only, all rows of one direction come before all
rows of the other, so that any step or drift in time looks the same."""


class Hysteresis(ScalarEffect):
    """Adds ± half the reversal error to the reference run, by direction."""

    name = "hysteresis"
    physics = (
        "Friction twists the shaft between disc and table; the sign of the twist depends on the "
        "direction of motion. Both heads are at the disc and do not see the twist."
    )
    equation = "ε = d·B/2, d = ±1 direction, B reversal error"
    source = "ISO 230-2, reversal error of an axis"
    capture_sees = "almost nothing"
    reference_sees = "positive and negative approach differ by B at every station"
    separated_by = "a reference run in both directions"
    next_measurement = "one more reference run in both directions"
    plausible = "0.1 to 5″"
    parameter_units = {"reversal_error": "arcsec"}
    compensation = "modulators"
    compensation_note = (
        "the correction follows the direction of approach; the default bitstream cannot correct it"
    )
    parameter_name = "reversal_error"
    parameter_unit = "arcsec"
    in_parts = ("direction", "reference")

    def missing(self, observations: Observations) -> list[str]:
        rows = observations.reference
        if rows is None:
            return ["a reference run"]
        if rows.direction is None:
            return ["the column direction in the reference run"]
        if rows.direction.min() == rows.direction.max():
            return ["a reference run in both directions"]
        return []

    def variety(self, observations: Observations) -> list[str]:
        rows = observations.reference
        if rows is None or rows.direction is None:
            return []
        if np.count_nonzero(np.diff(rows.direction)) >= LEAST_REVERSALS:
            return []
        return [
            "the reference run up and down once more: a change with time at its only reversal "
            "looks the same"
        ]

    def conditioned_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[ConditionedLane]:
        return [ConditionedLane("direction", Lane(0, 0.5 * float(coefficients[0]), 0.0))]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        return None if rows.direction is None else 0.5 * rows.direction[:, None]
