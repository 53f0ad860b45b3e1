"""The disc has an error at one order above the orders of ``graduation_harmonics``."""

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
    SearchParameter,
    amplitude_and_phase,
)
from arctrue.workbench.effects.missing import lacking_capture
from arctrue.workbench.numeric.harmonics import disc_difference, harmonic_columns
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows


class HighOrderGraduation(Effect):
    """Adds c·cos nψ + s·sin nψ with n above the setting ``above``; a search of the order spectrum
    finds n."""

    name = "high_order_graduation"
    physics = (
        "The machine that ruled the disc, or a ring of screws that holds the disc, causes an "
        "error with many periods per turn. The error turns with the disc like every graduation "
        "error."
    )
    equation = "ε(ψ) = c cos nψ + s sin nψ; the fit searches for the order n above N"
    source = "the paper (docs/paper.md), equation (5), for orders above its N"
    capture_sees = "order n with the factor e^{jnα} − 1"
    reference_sees = (
        "order n if there are more than 2n stations per turn; with 24 faces, the alias n mod 24"
    )
    separated_by = (
        "a peak at an integer order in the order spectrum of R₂ − R₁; a reference run alone "
        "cannot separate it from periodic_error"
    )
    next_measurement = "a capture with more samples per turn than this set has"
    plausible = "0.05 to 2″"
    parameter_units = {"order": "1", "amplitude": "arcsec", "phase": "deg"}
    compensation = "lanes"
    at_reading = True
    search_kind = "disc_order"
    search = (SearchParameter("order", "1", 21.0, 4096.0, "periods per turn", integer=True),)
    defaults = {"above": 20}

    def disc_orders(self, nonlinear: Nonlinear) -> Sequence[int]:
        return (round(nonlinear["order"]),)

    def missing(self, observations: Observations) -> list[str]:
        # With one head, an order of the disc looks the same as the cogging of a motor or the error
        # of a gear.
        return [] if observations.capture is not None else [lacking_capture()]

    @property
    def _above(self) -> int:
        above = self.settings["above"]
        assert isinstance(above, int)
        return above

    def search_range(self, name: str) -> tuple[float, float]:
        return self._above + 1.0, self.search[0].high

    def column_names(self, observations: Observations) -> list[str]:
        return ["cos", "sin"]

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return disc_difference(rows.line1_rad, rows.line2_rad, [nonlinear["order"]])

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return harmonic_columns(rows.line_rad, [nonlinear["order"]])

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        found = {"order": Parameter(nonlinear["order"], 0.0, "1")}
        return found | amplitude_and_phase(coefficients[0], coefficients[1], covariance, "")
