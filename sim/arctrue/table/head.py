"""Defines a read head, a fixed point from which the lines of the disc are read."""

from __future__ import annotations

import cmath
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Head:
    """A read head at a point of the stator plane.

    ``point_m`` is x + jy in metres; the nominal axis of the table is the origin.
    """

    point_m: complex
    """Point x + jy of the stator plane, metres."""
    index_offset_counts: int = 0
    """Number of counts by which this head detects the index mark too late when the table turns
    counter-clockwise."""

    def __post_init__(self) -> None:
        """Raise ValueError for a head on the axis."""
        if self.point_m == 0:
            raise ValueError("a read head cannot stand on the axis of the table")

    @classmethod
    def on_circle(cls, radius_m: float, angle_rad: float, index_offset_counts: int = 0) -> Head:
        """Return a head on a circle about the axis.

        Parameters
        ----------
        radius_m : float
            Distance from the axis, metres.
        angle_rad : float
            Stator angle β, radians.
        index_offset_counts : int
            Number of counts by which the head detects the index mark too late.

        Returns
        -------
        Head
            The head.

        Raises
        ------
        ValueError
            If the radius is 0.
        """
        return cls(cmath.rect(radius_m, angle_rad), index_offset_counts)

    @property
    def angle_rad(self) -> float:
        """Stator angle β of the head, radians."""
        return cmath.phase(self.point_m)
