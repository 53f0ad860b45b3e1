"""Computes the repeatability and the uncertainty of the measurement by equations (13) to (17) of
the paper."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

COVERAGE_FACTOR = 2.0
"""k₉₅ of equation (17), for a normal distribution."""


def bessel_deviation(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Calculate the standard deviation of a single value at every face, equation (13).

    Parameters
    ----------
    values : ndarray
        Values of all cycles in any unit, shape (cycles, faces).

    Returns
    -------
    ndarray
        Standard deviations in the same unit, shape (faces,).

    Raises
    ------
    ValueError
        If there are fewer than two cycles.
    """
    if values.ndim != 2 or values.shape[0] < 2:
        raise ValueError(f"need (cycles, faces) with two cycles or more, found {values.shape}")
    return np.asarray(np.std(values, axis=0, ddof=1))


def mounting_eccentricity_rad(offset_m: float, flatness_m: float, width_m: float) -> float:
    """Calculate u₄ of a hollow face that is not observed in its middle.

    This is equation (14) without its factor ρ, which converts to arcseconds.

    Parameters
    ----------
    offset_m : float
        Distance of the observed spot from the middle of the face, metres.
    flatness_m : float
        Depth by which the face is hollow, metres.
    width_m : float
        Width of the face, metres.

    Returns
    -------
    float
        Radians.
    """
    return 8.0 * offset_m * flatness_m / width_m**2


def tower_difference_rad(working_angle_rad: float, tilt_rad: float) -> float:
    """Calculate u₅ of faces that are tilted against the axis.

    This is equation (15) without its factor ρ, which converts to arcseconds.

    Parameters
    ----------
    working_angle_rad : float
        Angle from one face to the next, radians.
    tilt_rad : float
        Largest tilt of a face, radians.

    Returns
    -------
    float
        Radians.
    """
    return float(np.sin(working_angle_rad) * np.sin(tilt_rad) ** 2 / np.cos(tilt_rad))


@dataclass(frozen=True)
class UncertaintyBudget:
    """Standard uncertainties of the paper's Table 3 in arcseconds; they are uncorrelated."""

    polygon_arcsec: float
    """u₁: uncertainty of the polygon by its certificate."""
    autocollimator_arcsec: float
    """u₂: uncertainty of the autocollimator."""
    repeatability_arcsec: float
    """u₃: repeatability of the measurement."""
    mounting_eccentricity_arcsec: float
    """u₄: effect of hollow faces that are not observed in their middle."""
    tower_difference_arcsec: float
    """u₅: effect of faces that are tilted against the axis."""

    @property
    def combined_arcsec(self) -> float:
        """Return the combined standard uncertainty, equation (16)."""
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
        """Return the expanded uncertainty, equation (17)."""
        return COVERAGE_FACTOR * self.combined_arcsec
