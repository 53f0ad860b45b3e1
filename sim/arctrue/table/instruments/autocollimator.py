"""Simulates an autocollimator that looks at the faces of a polygon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]


@dataclass(frozen=True)
class Autocollimator:
    """An autocollimator with two errors: a fixed error for each face, and a random scatter.

    Parameters
    ----------
    error_rad : ndarray, shape (faces,)
        Error of the reading at each face, radians.
    scatter_rad : float
        Standard deviation of a reading, radians.
    """

    error_rad: Float
    scatter_rad: float

    def reading_rad(
        self, face: NDArray[np.intp], direction_rad: Float, random: np.random.Generator
    ) -> Float:
        """Return the readings of the directions of faces.

        Parameters
        ----------
        face : ndarray of int, shape (n,)
            Number of the face at each reading.
        direction_rad : ndarray, shape (n,)
            True direction, radians.
        random : numpy.random.Generator
            Source of the scatter.

        Returns
        -------
        ndarray, shape (n,)
            Readings, radians.
        """
        scatter = random.normal(0.0, self.scatter_rad, direction_rad.shape)
        return np.asarray(direction_rad + self.error_rad[face] + scatter)
