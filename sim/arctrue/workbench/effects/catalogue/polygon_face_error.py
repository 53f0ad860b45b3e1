"""The faces of the polygon are not at equal angles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Columns, Effect, FitContext, Nonlinear, Parameter
from arctrue.workbench.observations import Observations, ReferenceRows


class PolygonFaceError(Effect):
    """One constant a face, in the reference run."""

    name = "polygon_face_error"
    physics = (
        "Each face of the polygon is off its nominal angle by an amount of its own. This belongs "
        "to the polygon, not to the table, and moves with it when it is put on anew."
    )
    equation = "ε = f_i at face i, Σ f_i = 0"
    source = "paper, Table 3, u₁; EURAMET cg-19"
    capture_sees = "nothing"
    reference_sees = "the same at every visit of a face"
    told_apart_by = "it belongs to the face: re-index the polygon and it moves along"
    next_measurement = "a reference run with the polygon re-indexed by some faces"
    plausible = "0.1 to 0.5″"
    parameter_units = {"rms": "arcsec", "face_I": "arcsec"}
    compensation_note = "an error of the reference, not of the table"

    def missing(self, observations: Observations) -> list[str]:
        lacking = []
        if observations.reference is None:
            lacking.append("a reference run")
        elif observations.reference.face is None:
            lacking.append("the key reference.faces, and stations at the faces")
        if observations.capture is None:
            lacking.append("a capture of both heads: the table's own error hides the faces")
        return lacking

    def column_names(self, observations: Observations) -> list[str]:
        return [f"face {index}" for index in range(observations.faces or 0)]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.face is None or rows.faces is None:
            return None
        columns = np.zeros((rows.face.size, rows.faces))
        columns[np.arange(rows.face.size), rows.face] = 1.0
        # Σ f_i = 0: the constant belongs to a₀.
        return columns - 1.0 / rows.faces

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        count = coefficients.size
        centre = np.eye(count) - 1.0 / count
        values, spread = centre @ coefficients, centre @ covariance @ centre
        sigma = np.sqrt(np.maximum(np.diag(spread), 0.0))
        found = {
            "rms": Parameter(
                float(np.sqrt(np.mean(values**2))), float(np.sqrt(np.mean(sigma**2))), "arcsec"
            )
        }
        for index, (value, error) in enumerate(zip(values, sigma, strict=True)):
            found[f"face_{index}"] = Parameter(float(value), float(error), "arcsec")
        return found
