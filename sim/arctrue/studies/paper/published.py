"""Contains the figures that the paper publishes in section 4 and tables 2 and 3."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.studies.paper.budget import UncertaintyBudget
from arctrue.table.instruments import Autocollimator, Polygon, polygon


@dataclass(frozen=True)
class Published:
    """Figures that the paper publishes; in arcseconds unless the name has another unit."""

    faces: int = polygon.FACES
    """Number of faces of the polygon."""
    cycles: int = 10
    """Number of cycles of the measurement."""
    before_arcsec: tuple[float, float] = (-150.0, 137.9)
    """Smallest and largest error before the calibration."""
    after_arcsec: tuple[float, float] = (-1.3, 1.6)
    """Smallest and largest error after the calibration."""
    largest_deviation_arcsec: float = 0.2
    """Largest standard deviation of the error at a face between the cycles."""
    mounting_offset_m: float = polygon.MOUNTING_OFFSET_M
    """Distance of the observed spot from the middle of a face, metres."""
    flatness_m: float = polygon.FLATNESS_M
    """Flatness deviation of a face, metres."""
    face_width_m: float = polygon.FACE_WIDTH_M
    """Width of a face, metres."""
    tilt_arcsec: float = 8.0
    """Largest tilt of a face against the axis."""
    budget: UncertaintyBudget = field(
        default_factory=lambda: UncertaintyBudget(0.1, 0.05, 0.2, 0.0005, 0.0001)
    )
    """Standard uncertainties that Table 3 of the paper states."""
    combined_arcsec: float = 0.23
    """Combined standard uncertainty that the paper states."""
    expanded_arcsec: float = 0.46
    """Expanded uncertainty that the paper states, k = 2."""

    def drawn_polygon(self, random: np.random.Generator) -> Polygon:
        """Draw the errors of a polygon from the published uncertainties.

        Parameters
        ----------
        random : numpy.random.Generator
            Source of the deviations.

        Returns
        -------
        Polygon
            The polygon. The errors of its normals have a normal distribution with the certificate's
            u; its tilts have a rectangular distribution.
        """
        certificate_rad = self.budget.polygon_arcsec / ARCSEC_PER_RAD
        tilt_rad = self.tilt_arcsec / ARCSEC_PER_RAD
        return Polygon(
            normal_rad=random.normal(0.0, certificate_rad, self.faces),
            tilt_rad=random.uniform(-tilt_rad, tilt_rad, self.faces),
            flatness_m=self.flatness_m,
            width_m=self.face_width_m,
            offset_m=self.mounting_offset_m,
            offset_phase_rad=float(random.uniform(0.0, 2.0 * np.pi)),
        )

    def drawn_autocollimator(
        self, scatter_arcsec: float, random: np.random.Generator
    ) -> Autocollimator:
        """Draw the errors of an autocollimator from the published uncertainty.

        Parameters
        ----------
        scatter_arcsec : float
            Standard deviation of one reading, arcseconds.
        random : numpy.random.Generator
            Source of the errors.

        Returns
        -------
        Autocollimator
            The autocollimator, with one systematic error for each face.
        """
        error_rad = self.budget.autocollimator_arcsec / ARCSEC_PER_RAD
        return Autocollimator(
            random.normal(0.0, error_rad, self.faces), scatter_arcsec / ARCSEC_PER_RAD
        )


PUBLISHED = Published()
