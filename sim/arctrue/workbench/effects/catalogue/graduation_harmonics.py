"""The disc has an error at each order; the default model contains these errors."""

from __future__ import annotations

from collections.abc import Sequence

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
from arctrue.workbench.numeric.arc_curve import arc_curves
from arctrue.workbench.numeric.harmonics import disc_difference, harmonic_columns, harmonic_names
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows


class GraduationHarmonics(Effect):
    """Adds ε(ψ) = Σ cₙ·cos nψ + sₙ·sin nψ, n = 1 … N, which is fixed to the disc.

    The setting ``arc_deg`` (first angle, length) replaces the orders by the curves that they form
    on this arc (:func:`arc_curves`).
    """

    name = "graduation_harmonics"
    physics = (
        "The centre of the disc is off the axis (order 1), the disc is oval or tilted (order 2), "
        "its clamping distorts it (orders 3 to 8), or its lines are not evenly spaced. These "
        "errors turn with the disc, so head 2 sees them α ahead of head 1."
    )
    equation = "ε(ψ) = Σ cₙ cos nψ + sₙ sin nψ; R₂ − R₁ − α = ε(θ + α) − ε(θ)"
    source = "the paper (docs/paper.md), equations (4), (5) and (9)"
    capture_sees = "order n with the factor e^{jnα} − 1"
    reference_sees = "order n; 24 faces cannot separate n from 24 − n"
    separated_by = (
        "nothing has to separate it, because the default model contains it; capture and reference "
        "run give the same coefficients of each order"
    )
    next_measurement = "a capture of whole turns with both heads"
    plausible = "order 1 up to 150″, orders 2 to 8 up to 2″"
    parameter_units = {"order_N_amplitude": "arcsec", "order_N_phase": "deg"}
    compensation = "lanes"
    defaults = {"orders": list(range(1, 21)), "arc_deg": []}

    @property
    def _arc_deg(self) -> tuple[float, float] | None:
        values = self.settings["arc_deg"]
        if not values:
            return None
        assert isinstance(values, list)
        if len(values) != 2 or not all(isinstance(value, (int, float)) for value in values):
            raise ValueError(
                "effect graduation_harmonics: setting arc_deg must list two angles in degrees, the "
                f"first angle and the length of the arc; found {values!r}"
            )
        return float(values[0]), float(values[1])

    def _curves(self, angle_rad: Columns) -> Columns:
        assert self._arc_deg is not None
        return arc_curves(angle_rad, self.integers("orders"), *self._arc_deg)

    def disc_orders(self, nonlinear: Nonlinear) -> Sequence[int]:
        return () if self._arc_deg else self.integers("orders")

    def column_names(self, observations: Observations) -> list[str]:
        if self._arc_deg:
            curves = self._curves(np.zeros(1)).shape[1]
            return [f"curve {number}" for number in range(1, curves + 1)]
        return harmonic_names(self.integers("orders"))

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        if self._arc_deg:
            return self._curves(rows.disc2_rad) - self._curves(rows.disc1_rad)
        return disc_difference(rows.disc1_rad, rows.disc2_rad, self.integers("orders"))

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        if self._arc_deg:
            return self._curves(rows.angle_rad)
        return harmonic_columns(rows.angle_rad, self.integers("orders"))

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        found: dict[str, Parameter] = {}
        if self._arc_deg:
            # The curves are orthogonal on the arc, and each has the RMS 1. The noise of the
            # coefficients adds the trace of their covariance to the sum of their squares.
            square = float(coefficients @ coefficients)
            rms = float(np.sqrt(max(square - float(np.trace(covariance)), 0.0)))
            variance = float(coefficients @ covariance @ coefficients)
            sigma = float(np.sqrt(max(variance, 0.0) / max(square, 1e-300)))
            return {"curve_rms": Parameter(rms, sigma, "arcsec")}
        for index, order in enumerate(self.integers("orders")):
            pair = slice(2 * index, 2 * index + 2)
            cosine, sine = coefficients[pair]
            found |= amplitude_and_phase(cosine, sine, covariance[pair, pair], f"order_{order}_")
        return found
