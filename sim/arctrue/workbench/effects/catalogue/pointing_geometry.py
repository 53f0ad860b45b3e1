"""The axes of a mount lean or are not square to each other, or the line of sight is not square to
the second axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Columns, Effect, FitContext, Nonlinear, Parameter
from arctrue.workbench.observations import Observations, ReferenceRows

HEIGHTS = ("elevation_deg", "declination_deg")
"""Names of the columns that contain the target's angle above the plane in which this axis turns:
for an alt-azimuth mount, for an equatorial mount."""
AZIMUTH = "azimuth_deg"
"""Column of the other axis' angle, if the axis under test is the elevation axis."""
LEAST_SPAN_DEG = 20.0
"""Smallest span of elevations E: over a smaller span at the horizon, tan E and sec E differ from
straight lines by less than 2 %."""
LEAST_AZIMUTH_SPAN_DEG = 90.0
"""Smallest span of azimuths: over a smaller span, cos A and sin A differ little from a constant and
a line."""
LEAST_ROWS = 8
"""Least number of rows: twice the number of coefficients."""
TILT = ("tilt_cosine", "tilt_sine")
OF_THE_SIGHT = ("squareness", "collimation")


class PointingGeometry(Effect):
    """Adds tan E·cos θ, tan E·sin θ, tan E and sec E, or cos A and sin A, to the reference rows."""

    name = "pointing_geometry"
    physics = (
        "The first axis of a mount is tilted, the second axis is not square to it, or the line "
        "of sight is not square to the second axis. Each of these errors turns the line of "
        "sight away from the angle that the encoder reads; the error increases as the line of "
        "sight approaches the first axis."
    )
    equation = (
        "first axis: ε = (c cos θ + s sin θ + n)·tan E + k·sec E; "
        "second axis: ε = c cos A + s sin A; A and E: angles of the first and second axis (for "
        "example azimuth and elevation); c, s, n, k: constants; reference only"
    )
    source = "spherical trigonometry; terms AN, AW, NPAE and CA of pointing models"
    capture_sees = "nothing"
    reference_sees = "an error that depends on the angle of the mount's other axis"
    separated_by = "the angle of the other axis, recorded with each target"
    next_measurement = "a reference run with low and high targets all around the first axis"
    plausible = "1 to 100″ for each term; several arcminutes before the mount is aligned"
    parameter_units = dict.fromkeys(TILT, "arcsec")
    compensation_note = (
        "the error depends on the other axis: correct it in the mount's pointing model"
    )

    def concerns(self, observations: Observations) -> bool:
        rows = observations.reference
        return rows is not None and not {*HEIGHTS, AZIMUTH}.isdisjoint(rows.conditions)

    def missing(self, observations: Observations) -> list[str]:
        rows = observations.reference
        if rows is None:
            return ["a reference run"]
        height = _height_deg(rows)
        other = rows.conditions.get(AZIMUTH) if height is None else height
        if other is None:
            return [
                f"the column {' or '.join(HEIGHTS)}, or {AZIMUTH} if this axis moves in "
                "elevation, in the reference run"
            ]
        span_deg = LEAST_AZIMUTH_SPAN_DEG if height is None else LEAST_SPAN_DEG
        if other.size < LEAST_ROWS or not np.ptp(other) >= span_deg:
            return [f"{LEAST_ROWS} targets over {span_deg:g}° of the mount's other axis, or more"]
        if height is not None and not np.abs(height).max() < 90.0:
            return ["elevations between −90° and 90° in every row"]
        return []

    def column_names(self, observations: Observations) -> list[str]:
        rows = observations.reference
        first = rows is not None and _height_deg(rows) is not None
        return [*TILT, *OF_THE_SIGHT] if first else [*TILT]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        height = _height_deg(rows)
        if height is not None:
            slope = np.tan(np.radians(height))
            around = np.exp(1j * rows.angle_rad) * slope
            return np.column_stack(
                [around.real, around.imag, slope, 1.0 / np.cos(np.radians(height))]
            )
        azimuth = rows.conditions.get(AZIMUTH)
        if azimuth is None:
            return None
        return np.column_stack([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))])

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        sigma = np.sqrt(np.diag(covariance))
        return {
            name: Parameter(float(value), float(u), "arcsec")
            for name, value, u in zip(
                self.column_names(observations), coefficients, sigma, strict=True
            )
        }


def _height_deg(rows: ReferenceRows) -> NDArray[np.float64] | None:
    """Return the recorded angle above the plane of the first axis, in degrees; None if it was not
    recorded."""
    for name in HEIGHTS:
        if name in rows.conditions:
            return rows.conditions[name]
    return None
