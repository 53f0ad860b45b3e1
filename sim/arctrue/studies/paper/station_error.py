"""Computes the paper's figures from the readings of the autocollimator in every cycle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.studies.paper.budget import (
    UncertaintyBudget,
    bessel_deviation,
    mounting_eccentricity_rad,
    tower_difference_rad,
)
from arctrue.studies.paper.published import Published

Float = NDArray[np.float64]


@dataclass(frozen=True)
class StationErrors:
    """Positioning error at every face minus its mean over all faces, arcseconds, ``(faces,)``."""

    mean_arcsec: Float
    """Mean error over the cycles."""
    deviation_arcsec: Float
    """Standard deviation of the error between the cycles, for a single cycle."""

    @property
    def span_arcsec(self) -> tuple[float, float]:
        """Return the smallest and the largest mean error."""
        return float(self.mean_arcsec.min()), float(self.mean_arcsec.max())

    def budget(self, published: Published) -> UncertaintyBudget:
        """Calculate the uncertainty budget (Table 3) with the repeatability of these errors.

        Parameters
        ----------
        published : Published
            Uncertainties of polygon and autocollimator, and the geometry of the mounting.

        Returns
        -------
        UncertaintyBudget
            The budget. The budget's repeatability is the mean of the standard deviations of the
            faces.
        """
        return UncertaintyBudget(
            published.budget.polygon_arcsec,
            published.budget.autocollimator_arcsec,
            float(np.mean(self.deviation_arcsec)),
            ARCSEC_PER_RAD
            * mounting_eccentricity_rad(
                published.mounting_offset_m, published.flatness_m, published.face_width_m
            ),
            ARCSEC_PER_RAD
            * tower_difference_rad(
                2.0 * np.pi / published.faces, published.tilt_arcsec / ARCSEC_PER_RAD
            ),
        )


def station_errors(readings_rad: Float) -> StationErrors:
    """Calculate the errors of the faces: error = −reading.

    If the table has turned beyond its target, the face has turned by the same angle. The mean of
    each cycle is removed because its zero is arbitrary: the autocollimator is set to zero before a
    cycle.

    Parameters
    ----------
    readings_rad : ndarray
        Readings of the autocollimator, radians, shape (cycles, faces).

    Returns
    -------
    StationErrors
        Mean and standard deviation of each face.

    Raises
    ------
    ValueError
        If there are fewer than two cycles.
    """
    errors = -ARCSEC_PER_RAD * (readings_rad - readings_rad.mean(axis=1, keepdims=True))
    return StationErrors(errors.mean(axis=0), bessel_deviation(errors))


def residual_orders(error_arcsec: Float) -> Float:
    """Return the amplitude of each order that the faces determine, 1 … faces/2, Fig. 11 b.

    Parameters
    ----------
    error_arcsec : ndarray
        Error of each face, arcseconds, shape (faces,).

    Returns
    -------
    ndarray
        Amplitudes, arcseconds, shape (faces // 2,).
    """
    lines = np.fft.rfft(error_arcsec) / error_arcsec.size
    amplitude = 2.0 * np.abs(lines[1:])
    if error_arcsec.size % 2 == 0:
        amplitude[-1] /= 2.0
    return np.asarray(amplitude)
