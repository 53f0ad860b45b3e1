"""The angle between the heads differs from the α of the measurement set."""

from __future__ import annotations

from arctrue.workbench.effects.base import Columns, FitContext, Nonlinear
from arctrue.workbench.effects.conditions import one_velocity
from arctrue.workbench.effects.missing import lacking_capture
from arctrue.workbench.effects.scalar_effect import ScalarOfEachHead
from arctrue.workbench.observations import CaptureRows, Observations


class HeadAngleError(ScalarOfEachHead):
    """Adds Δα·(1 + ε′(θ + α)) to R₂ − R₁: a constant and a small part of every order."""

    name = "head_angle_error"
    physics = (
        "The separation of the heads is α + Δα instead of α, so the factor e^{jnα} − 1, by which "
        "the calibration divides, is wrong at every order n, and the mean of R₂ − R₁ shows Δα. The "
        "relative error of a coefficient is n·Δα divided by the factor's magnitude (at α = 33° and "
        "order 11: 210·Δα, Δα in rad)."
    )
    physics_of_one = (
        "Head {head} stands Δα away from its stated place: the mean of its reading minus those of "
        "the other heads shows Δα, and the factors by which the calibration divides are wrong at "
        "every order n of the disc, by n·Δα (Δα in rad) at this head."
    )
    equation = "δ₂₁ = Δα·(1 + ε′(θ + α)) + ε(θ + α) − ε(θ), first order in Δα"
    source = "the paper (docs/paper.md), equation (3) with α + Δα"
    capture_sees = "the mean of R₂ − R₁ − α, and Δα·ε′"
    reference_sees = "nothing"
    separated_by = "the mean of R₂ − R₁ is the same at every speed, direction and temperature"
    next_measurement = (
        "more runs, each with its own index pass: each run gives the mean within ±1 count"
    )
    plausible = "±50″ is the mounting tolerance"
    parameter_units = {"head_angle_error": "arcsec"}
    compensation = "none"
    compensation_note = "the output has no such error; use the measured α in the calibration"
    note_of_one = "the output has no such error; use the measured place in the calibration"
    note_of_head1 = "the output has only this constant; use the measured places in the calibration"
    depends_on_model = True
    parameter_name = "head_angle_error"
    parameter_unit = "arcsec"

    def missing(self, observations: Observations) -> list[str]:
        return [] if observations.capture is not None else [lacking_capture()]

    def variety(self, observations: Observations) -> list[str]:
        return one_velocity(observations)

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return self.columns(1.0 + context.error_slope(rows.disc2_rad), rows)
