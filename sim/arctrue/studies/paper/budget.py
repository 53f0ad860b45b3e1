"""Repeatability and uncertainty of the measurement: equations (13) to (17)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

COVERAGE_FACTOR = 2.0
"""k₉₅ of equation (17), for a normal distribution."""


def bessel_deviation(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Standard deviation of a single value at every face, equation (13).

    ``values`` has shape ``(cycles, faces)``; the answer ``(faces,)``, in the same unit.
    Raises ValueError for less than two cycles.
    """
    if values.ndim != 2 or values.shape[0] < 2:
        raise ValueError(f"need (cycles, faces) with two cycles or more, found {values.shape}")
    return np.asarray(np.std(values, axis=0, ddof=1))


def mounting_eccentricity_rad(offset_m: float, flatness_m: float, width_m: float) -> float:
    """u₄: a face of ``width_m``, hollow by ``flatness_m``, observed ``offset_m`` off its centre.

    Equation (14) without its factor ρ, which converts to arcseconds.
    """
    return 8.0 * offset_m * flatness_m / width_m**2


def tower_difference_rad(working_angle_rad: float, tilt_rad: float) -> float:
    """u₅: faces tilted by up to ``tilt_rad`` against the axis, equation (15) without ρ."""
    return float(np.sin(working_angle_rad) * np.sin(tilt_rad) ** 2 / np.cos(tilt_rad))


@dataclass(frozen=True)
class UncertaintyBudget:
    """Table 3: standard uncertainties, arcsec, uncorrelated."""

    polygon_arcsec: float
    autocollimator_arcsec: float
    repeatability_arcsec: float
    mounting_eccentricity_arcsec: float
    tower_difference_arcsec: float

    @property
    def combined_arcsec(self) -> float:
        """Equation (16)."""
        parts = (
            self.polygon_arcsec,
            self.autocollimator_arcsec,
            self.repeatability_arcsec,
            self.mounting_eccentricity_arcsec,
            self.tower_difference_arcsec,
        )
        return float(np.linalg.norm(parts))

    @property
    def expanded_arcsec(self) -> float:
        """Equation (17)."""
        return COVERAGE_FACTOR * self.combined_arcsec
