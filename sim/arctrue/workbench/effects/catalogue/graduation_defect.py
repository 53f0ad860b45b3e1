"""The disc has a scratch, dirt or a splice at one place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import (
    Columns,
    Effect,
    FitContext,
    LocalError,
    Nonlinear,
    Parameter,
    SearchParameter,
)
from arctrue.workbench.effects.missing import lacking_capture
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows


def bump(angle_rad: NDArray[np.float64], nonlinear: Nonlinear) -> NDArray[np.float64]:
    """Return a bell of height 1 around ``place`` (degrees) with the standard deviation ``width``
    (degrees)."""
    away = angle_rad - np.radians(nonlinear["place"])
    away = (away + np.pi) % (2.0 * np.pi) - np.pi
    return np.asarray(np.exp(-0.5 * (away / np.radians(nonlinear["width"])) ** 2))


FAR_WIDTHS = 5.0
"""Distance from the middle, in standard deviations, at which the bell is below 4·10⁻⁶ of its
height."""


class GraduationDefect(Effect):
    """Adds a bell-shaped error of adjustable width at one disc angle."""

    name = "graduation_defect"
    physics = (
        "A scratch, dirt or a splice shifts the light pattern while it passes under a head. "
        "Both heads meet it at the same disc angle, but at table angles α apart, so R₂ − R₁ "
        "contains the error twice, with opposite signs."
    )
    equation = "ε(ψ) = h·exp(−(ψ − ψ₀)²/2w²); the fit searches for ψ₀ and w"
    source = "a local error of the graduation"
    capture_sees = "the error twice, at table angles α apart, with opposite signs"
    reference_sees = "the error at one station at most"
    separated_by = "both heads see the error at the same disc angle"
    local_on_disc = True
    next_measurement = "a slow capture with many samples across the defect"
    plausible = "0.5 to 20″ high, 0.05 to 5° wide"
    parameter_units = {"place": "deg", "width": "deg", "height": "arcsec"}
    compensation = "local_table"
    compensation_note = (
        "lanes of low orders are too smooth to correct it; without this table, clean or replace "
        "the disc"
    )
    search_kind = "disc_place"
    search = (
        SearchParameter("place", "deg", 0.0, 360.0, "disc angle of the defect"),
        SearchParameter("width", "deg", 0.02, 12.0, "standard deviation of the bell"),
    )

    def missing(self, observations: Observations) -> list[str]:
        return [] if observations.capture is not None else [lacking_capture()]

    def column_names(self, observations: Observations) -> list[str]:
        return ["height"]

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return (bump(rows.line2_rad, nonlinear) - bump(rows.line1_rad, nonlinear))[:, np.newaxis]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return bump(rows.line_rad, nonlinear)[:, np.newaxis]

    def local_error(
        self, coefficients: NDArray[np.float64], nonlinear: Nonlinear
    ) -> LocalError | None:
        height_arcsec = float(coefficients[0])
        return LocalError(
            float(np.radians(nonlinear["place"])),
            FAR_WIDTHS * float(np.radians(nonlinear["width"])),
            lambda reading_rad: height_arcsec * bump(reading_rad, nonlinear),
        )

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        sigma = float(np.sqrt(max(covariance[0, 0], 0.0)))
        return {
            "place": Parameter(nonlinear["place"], float("nan"), "deg"),
            "width": Parameter(nonlinear["width"], float("nan"), "deg"),
            "height": Parameter(float(coefficients[0]), sigma, "arcsec"),
        }
