"""The disc is not centred on the axis."""

from __future__ import annotations

import cmath
from dataclasses import dataclass

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class DiscEccentricity(PhysicalEffect):
    """The disc centre lies ``offset_m`` off the axis and turns with the table.

    ``direction_rad``: towards which table angle. For a small offset the reading errs by
    (offset / head radius)·sin(θ + direction − β); the table works out the exact ray.
    """

    offset_m: float
    direction_rad: float = 0.0

    def disc_shift_m(self, state: TableState) -> complex:
        """Displacement in the frame of the turning table, metres."""
        return cmath.rect(self.offset_m, self.direction_rad)
