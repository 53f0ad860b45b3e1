"""The reference has an error of order 1, which the table does not have."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import (
    Columns,
    Effect,
    FitContext,
    Nonlinear,
    Parameter,
    amplitude_and_phase,
)
from arctrue.workbench.effects.missing import lacking_capture
from arctrue.workbench.numeric.harmonics import harmonic_columns
from arctrue.workbench.observations import Observations, ReferenceRows


class PolygonEccentricity(Effect):
    """Adds cos θ and sin θ to the reference rows only."""

    name = "polygon_eccentricity"
    physics = (
        "The polygon is tilted, so that its faces tilt up and down once per turn: an "
        "autocollimator rolled by ρ about its line of sight reads tilt·sin ρ as an angle. A "
        "polygon off the axis by s causes the small error 8sh/H² (0.0005″ per µm of s in the "
        "paper) if its faces of width H are concave by h; if the reference is an encoder of radius "
        "r, an offset s from the axis causes the error s/r."
    )
    equation = "ε = c cos θ + s sin θ, reference only"
    source = (
        "the paper (docs/paper.md), equation (14), for the offset; law of reflection for the tilt"
    )
    capture_sees = "nothing"
    reference_sees = "order 1"
    separated_by = "at order 1 the coefficients from two heads differ from those of the reference"
    next_measurement = "a reference run with the polygon re-indexed by some faces"
    plausible = "0.05 to 1″ by tilt (30″ at a roll of 1°: 0.5″); 0.0005″ per µm by the offset"
    parameter_units = {"amplitude": "arcsec", "phase": "deg"}
    compensation = "reference"
    compensation_note = "an error of the reference, not of the table"
    fixed_to_polygon = True

    def missing(self, observations: Observations) -> list[str]:
        lacking: list[str] = []
        if observations.reference is None:
            lacking.append("a reference run")
        if observations.capture is None:
            lacking.append(lacking_capture("the table's own order 1 hides it"))
        return lacking

    def column_names(self, observations: Observations) -> list[str]:
        return ["cos", "sin"]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return harmonic_columns(rows.angle_rad, [1])

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        return amplitude_and_phase(coefficients[0], coefficients[1], covariance, "")
