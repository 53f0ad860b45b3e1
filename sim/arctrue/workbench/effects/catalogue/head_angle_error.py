"""The heads are not at the angle that the method takes for α."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Columns, Effect, FitContext, Nonlinear, Parameter
from arctrue.workbench.observations import CaptureRows, Observations


class HeadAngleError(Effect):
    """Δα·(1 + ε′(θ + α)) in R₂ − R₁: a constant, and every order a little."""

    name = "head_angle_error"
    physics = (
        "Head 2 stands Δα further from head 1 than α. The transfer function is then wrong at every "
        "order, most at the weak ones (210 Δα at order 11), and the mean of R₂ − R₁ shows Δα "
        "itself."
    )
    equation = "δ₂₁ = Δα·(1 + ε′(θ + α)) + ε(θ + α) − ε(θ), first order in Δα"
    source = "equation (3) with α + Δα"
    capture_sees = "the mean of R₂ − R₁ − α, and Δα·ε′"
    reference_sees = "nothing"
    told_apart_by = "the mean of R₂ − R₁ in every run, whatever its speed, direction, temperature"
    next_measurement = (
        "more runs, each with its own index pass: the mean is known to ±1 count a run"
    )
    plausible = "±50″ is the mounting tolerance"
    parameter_units = {"head_angle_error": "arcsec"}
    compensation = "none"
    compensation_note = "nothing to correct: use the measured α in the calibration"
    depends_on_model = True

    def missing(self, observations: Observations) -> list[str]:
        return [] if observations.capture is not None else ["a capture of both heads"]

    def variety(self, observations: Observations) -> list[str]:
        rows = observations.capture
        if rows is None:
            return []
        speeds = np.unique(np.round(rows.speed_rad_s, 3))
        return [] if speeds.size > 1 else ["runs at more than one speed or direction"]

    def column_names(self, observations: Observations) -> list[str]:
        return ["head_angle_error"]

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return (1.0 + context.error_slope(rows.disc2_rad))[:, np.newaxis]

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        return {
            "head_angle_error": Parameter(
                float(coefficients[0]), float(np.sqrt(covariance[0, 0])), "arcsec"
            )
        }
