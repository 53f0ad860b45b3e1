"""The reading of the table is delayed and shows the angle of an earlier instant."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.workbench.effects.base import Columns, ConditionedLane, FitContext, Lane, Nonlinear
from arctrue.workbench.effects.scalar_effect import ScalarEffect
from arctrue.workbench.observations import Observations, ReferenceRows

LEAST_DELAY_US = 1e-3
"""Smallest delay with which the column is calculated; it replaces any smaller delay."""


class Latency(ScalarEffect):
    """Adds the effect of a reading delayed by τ to a reference run in motion: a constant and every
    order."""

    name = "latency"
    physics = (
        "A reading reaches the user with a delay τ. While the table moves at the speed ω, the "
        "reading belongs to the earlier angle θ − ωτ and has the error at that angle; both heads "
        "have the same delay, so only a reference shows it."
    )
    equation = "measured ε = ε(θ − ωτ) − ωτ"
    source = (
        "sampling of a moving scale; the paper's delay of 290 ns (docs/paper.md) is a part of τ"
    )
    capture_sees = "nothing if both heads have the same delay"
    reference_sees = (
        "only in runs without stops: an offset proportional to the speed, and a phase shift nωτ "
        "of each order n"
    )
    separated_by = "a reference run at several speeds"
    next_measurement = "a reference run without stops, at a speed that this set does not have"
    plausible = "0.3 to 100 µs"
    parameter_units = {"latency": "us"}
    compensation = "modulators"
    compensation_note = "the correction follows the speed; the default bitstream cannot correct it"
    depends_on_model = True
    parameter_name = "latency"
    parameter_unit = "us"

    def missing(self, observations: Observations) -> list[str]:
        rows = observations.reference
        if rows is None:
            return ["a reference run"]
        if rows.speed_rad_s is None:
            return ["a reference run in motion (this one stands still at its stations)"]
        # For both directions at one speed, a delay looks the same as a reversal error.
        if np.unique(np.round(np.abs(rows.speed_rad_s), 6)).size < 2:
            return ["a reference run at more than one speed"]
        return []

    def conditioned_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[ConditionedLane]:
        # The gateware evaluates the error function at the delayed reading, which has this error;
        # only ωτ remains.
        behind_arcsec = float(coefficients[0]) * 1e-6 * ARCSEC_PER_RAD
        return [ConditionedLane("speed", Lane(0, -behind_arcsec, 0.0))]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.speed_rad_s is None:
            return None
        # The column is the change from no delay to the fitted delay, divided by the fitted delay;
        # it is exact for this delay.
        known = context.coefficients.get(self.name)
        delay_us = LEAST_DELAY_US if known is None else float(known[0])
        if abs(delay_us) < LEAST_DELAY_US:
            delay_us = LEAST_DELAY_US
        behind_rad = rows.speed_rad_s * delay_us * 1e-6
        total = context.shifted_arcsec(rows.angle_rad, -behind_rad) - behind_rad * ARCSEC_PER_RAD
        return np.asarray(total / delay_us)[:, np.newaxis]
