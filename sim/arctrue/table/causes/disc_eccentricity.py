"""Models a disc that is not centred on the axis."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

from arctrue.base.typed_content import Number
from arctrue.table.cause import Cause
from arctrue.table.declaration import MICROMETRE_M, Declaration, Given
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class DiscEccentricity(Cause):
    """The disc centre lies ``offset_m`` off the axis and turns with the table.

    At table angle 0 it lies in the direction ``direction_rad``. For a small offset, the reading of
    a head at the stator angle β has the error (offset / head radius)·sin(θ + direction − β); the
    table computes the exact ray.
    """

    offset_m: float
    """Distance from the axis to the disc centre, metres."""
    direction_rad: float = 0.0
    """Direction from the axis to the disc centre at table angle 0, radians."""

    def disc_shift_m(self, state: TableState) -> complex:
        """Return the displacement in the frame of the turning table.

        Parameters
        ----------
        state : TableState
            Instants at which the quantity is requested, shape (n,).

        Returns
        -------
        complex
            Displacement x + jy, metres, the same at all instants.
        """
        return cmath.rect(self.offset_m, self.direction_rad)


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    um: Number
    direction_deg: Number = 0.0

    def physical(self, lines: int) -> DiscEccentricity:
        """Return the cause that these values describe."""
        return DiscEccentricity(self.um * MICROMETRE_M, math.radians(self.direction_deg))


DECLARATION = Declaration(
    DiscEccentricity,
    values=Values,
)
