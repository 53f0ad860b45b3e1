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
from arctrue.workbench.numeric.harmonics import disc_difference, harmonic_columns, harmonic_names
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows


class GraduationHarmonics(Effect):
    """Adds ε(ψ) = Σ cₙ·cos nψ + sₙ·sin nψ, n = 1 … N, which is fixed to the disc."""

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
    defaults = {"orders": list(range(1, 21))}

    def disc_orders(self, nonlinear: Nonlinear) -> Sequence[int]:
        return self.integers("orders")

    def column_names(self, observations: Observations) -> list[str]:
        return harmonic_names(self.integers("orders"))

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return disc_difference(rows.disc1_rad, rows.disc2_rad, self.integers("orders"))

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return harmonic_columns(rows.angle_rad, self.integers("orders"))

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        found: dict[str, Parameter] = {}
        for index, order in enumerate(self.integers("orders")):
            pair = slice(2 * index, 2 * index + 2)
            cosine, sine = coefficients[pair]
            found |= amplitude_and_phase(cosine, sine, covariance[pair, pair], f"order_{order}_")
        return found
