"""Computes the geometry of a polygon on the table: the direction into which each face reflects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

FACES = 24
MOUNTING_OFFSET_M = 1e-6
FLATNESS_M = 0.03e-6
FACE_WIDTH_M = 10e-3
"""Polygon of the paper's section 4: number of faces, distance of the polygon's centre from the
axis, depth of a hollow face, and width of a face."""


def hollow_slope(flatness_m: float, sideways_m: Float, width_m: float) -> Float:
    """Return the slope in radians of a hollow face at ``sideways_m`` from its centre, in the same
    shape.

    The face is a parabola of depth ``flatness_m`` over ``width_m``: 8·offset·flatness/width²,
    equation (14) of the paper.
    """
    return np.asarray(8.0 * flatness_m * sideways_m / width_m**2)


@dataclass(frozen=True)
class Polygon:
    """True geometry of the faces, as deviations from the certificate.

    Parameters
    ----------
    normal_rad : ndarray, shape (faces,)
        Error of each face's direction about the axis after the certificate's correction, radians.
    tilt_rad : ndarray, shape (faces,)
        Angle of each face's normal to the plane of measurement, radians.
    flatness_m : float
        Depth of each hollow face over its width, metres.
    width_m : float
        Width of a face, metres.
    offset_m : float
        Distance of the polygon's centre from the axis, metres.
    offset_phase_rad : float
        Direction of that offset, radians; it turns with the table.
    """

    normal_rad: Float
    tilt_rad: Float
    flatness_m: float
    width_m: float
    offset_m: float
    offset_phase_rad: float

    @property
    def faces(self) -> int:
        """Number of faces."""
        return int(self.normal_rad.size)

    def direction_rad(self, face: NDArray[np.intp], deviation_rad: Float) -> Float:
        """Return the direction of each face about the axis, as the reflected ray shows it.

        The ray meets the face at a distance from its centre, the sideways part of the mounting
        offset; there a hollow mirror (a parabola of depth ``flatness_m``) has another slope. By the
        law of reflection in space, a tilted face reflects into another horizontal direction than an
        upright one.

        Parameters
        ----------
        face : ndarray of int, shape (n,)
            Number of the face.
        deviation_rad : ndarray, shape (n,)
            Angle of the table minus the nominal angle of the face, radians.

        Returns
        -------
        ndarray, shape (n,)
            Directions, radians.
        """
        angle = 2.0 * np.pi * face / self.faces
        sideways_m = self.offset_m * np.sin(angle + self.offset_phase_rad)
        slope = hollow_slope(self.flatness_m, sideways_m, self.width_m)
        upright = deviation_rad + self.normal_rad[face] + slope
        tilt = self.tilt_rad[face]
        normal = np.stack(
            [np.cos(tilt) * np.cos(upright), np.cos(tilt) * np.sin(upright), np.sin(tilt)]
        )
        ray = np.array([-1.0, 0.0, 0.0])[:, np.newaxis]
        reflected = ray - 2.0 * np.sum(ray * normal, axis=0) * normal
        return np.asarray(np.arctan2(reflected[1], reflected[0]) / 2.0)
