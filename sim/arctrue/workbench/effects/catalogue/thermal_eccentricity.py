"""The disc's centre moves as the table warms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import (
    Columns,
    Effect,
    FitContext,
    Lane,
    Nonlinear,
    Parameter,
    amplitude_and_phase,
    paired_lanes,
)
from arctrue.workbench.effects.catalogue.thermal_head_drift import LEAST_SPAN_K
from arctrue.workbench.numeric.harmonics import disc_difference, harmonic_columns
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows


class ThermalEccentricity(Effect):
    """Adds (T − T₀)·(c·cos ψ + s·sin ψ), which is fixed to the disc."""

    name = "thermal_eccentricity"
    physics = (
        "The hub that holds the disc expands unevenly and shifts its centre in proportion to the "
        "temperature. Order 1 of the graduation error then follows the temperature."
    )
    equation = "ε(ψ) = (T − T₀)·(c cos ψ + s sin ψ)"
    source = "eccentricity of a disc with a centre that moves linearly in T"
    capture_sees = "order 1 with the factor e^{jα} − 1, in proportion to T − T₀"
    reference_sees = "order 1 changes with T"
    separated_by = "order 1 at two temperatures"
    next_measurement = "a capture at a temperature that this set does not have"
    in_parts = ("temperature", "order:1", "disc")
    plausible = "0.1 to 0.9 µm/K (0.4 to 3.4″/K at a radius of 54 mm)"
    parameter_units = {"amplitude": "arcsec/K", "phase": "deg"}
    compensation = "lanes"
    compensation_note = (
        "the firmware calculates order 1 for the temperature of the table; the weighted mean of "
        "three or four heads does not contain order 1"
    )

    def missing(self, observations: Observations) -> list[str]:
        spans = [
            float(np.ptp(rows.temperature_c))
            for rows in (observations.capture, observations.reference)
            if rows is not None and rows.temperature_c is not None
        ]
        if not spans:
            return ["the column temperature_c"]
        if max(spans) < LEAST_SPAN_K:
            return [f"a temperature that changes by {LEAST_SPAN_K} K or more"]
        return []

    def column_names(self, observations: Observations) -> list[str]:
        return ["cos", "sin"]

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.temperature_c is None:
            return None
        warmth = rows.temperature_c - rows.reference_temperature_c
        return warmth[:, np.newaxis] * disc_difference(rows.disc1_rad, rows.disc2_rad, [1])

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.temperature_c is None:
            return None
        warmth = rows.temperature_c - rows.reference_temperature_c
        return warmth[:, np.newaxis] * harmonic_columns(rows.angle_rad, [1])

    def lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
        temperature_c: float | None,
    ) -> list[Lane]:
        if temperature_c is None:
            raise ValueError(f"{self.name}: state the temperature with --temperature")
        warmth = temperature_c - observations.reference_temperature_c
        return paired_lanes([1], warmth * coefficients)

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        return amplitude_and_phase(
            coefficients[0], coefficients[1], covariance, "", unit="arcsec/K"
        )
