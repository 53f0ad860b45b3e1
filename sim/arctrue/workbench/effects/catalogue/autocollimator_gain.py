"""The scale of the reference is a little too large or too small."""

from __future__ import annotations

from arctrue.workbench.effects.base import Columns, FitContext, Nonlinear
from arctrue.workbench.effects.missing import lacking_capture
from arctrue.workbench.effects.scalar_effect import ScalarEffect
from arctrue.workbench.observations import Observations, ReferenceRows


class AutocollimatorGain(ScalarEffect):
    """Adds gain·ε, proportional to the autocollimator's own reading, to the reference run."""

    name = "autocollimator_gain"
    physics = (
        "The autocollimator multiplies each angle that it measures by 1 + g. The additional "
        "error is proportional to the table's error and becomes smaller when the table is "
        "compensated."
    )
    equation = "measured ε = (1 + g)·ε(θ); reference only"
    source = "scale error of an autocollimator; its certificate"
    capture_sees = "nothing"
    reference_sees = "the table's error, multiplied by 1 + g"
    separated_by = "the additional error becomes smaller when the table is compensated"
    next_measurement = "the same reference run with the compensation on"
    plausible = "0.01 to 1 %"
    parameter_units = {"gain": "1"}
    compensation = "reference"
    compensation_note = "an error of the reference, not of the table"
    depends_on_model = True
    parameter_name = "gain"
    parameter_unit = "1"

    def missing(self, observations: Observations) -> list[str]:
        lacking: list[str] = []
        if observations.reference is None:
            lacking.append("a reference run")
        if observations.capture is None:
            lacking.append(lacking_capture("it gives the true size of the error"))
        return lacking

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return context.error_arcsec(rows.angle_rad)[:, None]
