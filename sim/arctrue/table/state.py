"""Holds the state of the table at a series of instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class TableState:
    """The state of the table at ``n`` instants; every array has the shape ``(n,)``.

    Causes depend on these quantities. A further quantity on which a new cause depends, such as a
    load, becomes a new field.
    """

    time_s: NDArray[np.float64]
    """Time of each instant, seconds."""
    angle_rad: NDArray[np.float64]
    """True angle of the table, radians, not wrapped, growing counter-clockwise."""
    speed_rad_s: NDArray[np.float64]
    """True speed with its sign, radians a second."""

    @classmethod
    def at_rest(cls, angle_rad: NDArray[np.float64]) -> TableState:
        """Return the state of a table that stands still at each of the given angles, at time 0.

        Parameters
        ----------
        angle_rad : ndarray
            True angles, radians, shape (n,).

        Returns
        -------
        TableState
            n instants with speed 0.
        """
        angle_rad = np.atleast_1d(np.asarray(angle_rad, dtype=np.float64))
        return cls(np.zeros_like(angle_rad), angle_rad, np.zeros_like(angle_rad))
