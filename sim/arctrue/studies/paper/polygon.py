"""A polygon on the table and an autocollimator that looks at its faces, as geometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.studies.paper.published import Published
from arctrue.units import ARCSEC_PER_RAD

Float = NDArray[np.float64]


@dataclass(frozen=True)
class Polygon:
    """Faces as they are, less what the certificate says of them.

    ``normal_rad`` is what the certificate leaves of each face's direction about the axis,
    ``tilt_rad`` how far its normal leans out of the plane of measurement, both shape ``(faces,)``.
    Each face is hollow by ``flatness_m`` over ``width_m``; its centre is ``offset_m`` off the axis,
    in the direction ``offset_phase_rad``, which turns with the table.
    """

    normal_rad: Float
    tilt_rad: Float
    flatness_m: float
    width_m: float
    offset_m: float
    offset_phase_rad: float

    @classmethod
    def drawn(cls, published: Published, random: np.random.Generator) -> Polygon:
        """One of the polygons that the paper's uncertainties allow."""
        certificate_rad = published.budget.polygon_arcsec / ARCSEC_PER_RAD
        tilt_rad = published.tilt_arcsec / ARCSEC_PER_RAD
        return cls(
            normal_rad=random.normal(0.0, certificate_rad, published.faces),
            tilt_rad=random.uniform(-tilt_rad, tilt_rad, published.faces),
            flatness_m=published.flatness_m,
            width_m=published.face_width_m,
            offset_m=published.mounting_offset_m,
            offset_phase_rad=float(random.uniform(0.0, 2.0 * np.pi)),
        )

    @property
    def faces(self) -> int:
        """How many there are."""
        return int(self.normal_rad.size)

    def direction_rad(self, face: NDArray[np.intp], deviation_rad: Float) -> Float:
        """Direction about the axis that a ray sees, with the table ``deviation_rad`` off nominal.

        The ray meets the face off its centre by the sideways part of the mounting offset; there a
        hollow mirror (a parabola of depth ``flatness_m``) stands at another slope. A face that
        leans reflects into another horizontal direction than an upright one: the law of
        reflection in space. Shapes ``(n,)``.
        """
        angle = 2.0 * np.pi * face / self.faces
        sideways_m = self.offset_m * np.sin(angle + self.offset_phase_rad)
        slope = 8.0 * self.flatness_m * sideways_m / self.width_m**2
        upright = deviation_rad + self.normal_rad[face] + slope
        tilt = self.tilt_rad[face]
        normal = np.stack(
            [np.cos(tilt) * np.cos(upright), np.cos(tilt) * np.sin(upright), np.sin(tilt)]
        )
        ray = np.array([-1.0, 0.0, 0.0])[:, np.newaxis]
        reflected = ray - 2.0 * np.sum(ray * normal, axis=0) * normal
        return np.asarray(np.arctan2(reflected[1], reflected[0]) / 2.0)


@dataclass(frozen=True)
class Autocollimator:
    """What it leaves of its own: an error at each face's place in its field, and scatter."""

    error_rad: Float
    scatter_rad: float

    @classmethod
    def drawn(
        cls, published: Published, scatter_arcsec: float, random: np.random.Generator
    ) -> Autocollimator:
        """One of those that the paper's uncertainty allows."""
        error_rad = published.budget.autocollimator_arcsec / ARCSEC_PER_RAD
        return cls(random.normal(0.0, error_rad, published.faces), scatter_arcsec / ARCSEC_PER_RAD)

    def reading_rad(
        self, face: NDArray[np.intp], direction_rad: Float, random: np.random.Generator
    ) -> Float:
        """Readings of directions, shape ``(n,)``."""
        scatter = random.normal(0.0, self.scatter_rad, direction_rad.shape)
        return np.asarray(direction_rad + self.error_rad[face] + scatter)
