"""A head's bracket expands with the temperature."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.effects.base import Columns, FitContext, Nonlinear
from arctrue.workbench.effects.missing import lacking_capture
from arctrue.workbench.effects.scalar_effect import ScalarOfEachHead
from arctrue.workbench.observations import CaptureRows, Observations

LEAST_SPAN_K = 0.2
"""Smallest change of the temperature, in kelvins, with which a thermal effect is fitted."""


class ThermalHeadDrift(ScalarOfEachHead):
    """Adds (T − T₀)·rate to R₂ − R₁."""

    name = "thermal_head_drift"
    physics = (
        "The bracket of head 2 expands and moves the head along the disc. The difference of the "
        "heads drifts with the temperature, equally at every angle."
    )
    physics_of_one = (
        "The bracket of head {head} expands and moves this head along the disc. Its reading drifts "
        "with the temperature against those of the other heads, equally at every angle."
    )
    equation = "δ₂₁ = (T − T₀)·s"
    source = "thermal expansion of a bracket"
    capture_sees = "the mean drifts with T"
    reference_sees = "nothing, because the reference is compared with head 1"
    separated_by = "a temperature that does not change in proportion to time"
    next_measurement = "a capture while the table warms and cools again"
    plausible = "0.05 to 5″/K"
    parameter_units = {"drift": "arcsec/K"}
    compensation_note = (
        "the output does not contain head 2; the calibration must use the angle α at the present "
        "temperature"
    )
    note_of_one = (
        "the output does not contain head {head}; the calibration must use the place of this head "
        "at the present temperature"
    )
    note_of_head1 = "the output is the reading of head 1, which drifts with the temperature"
    parameter_name = "drift"
    parameter_unit = "arcsec/K"
    in_parts = ("temperature", "head2")
    zero_is_unknown = True

    def missing(self, observations: Observations) -> list[str]:
        rows = observations.capture
        if rows is None:
            return [lacking_capture()]
        if rows.temperature_c is None:
            return ["the column temperature_c in the capture"]
        if float(np.ptp(rows.temperature_c)) < LEAST_SPAN_K:
            return [f"a temperature that changes by {LEAST_SPAN_K} K or more in the capture"]
        return []

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.temperature_c is None:
            return None
        return self.columns(rows.temperature_c - rows.reference_temperature_c, rows)
