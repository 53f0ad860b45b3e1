"""A head stands elsewhere than the drawing says."""

from __future__ import annotations

import cmath
from dataclasses import dataclass

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.head import Head
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class BracketTurn(PhysicalEffect):
    """The bracket of one head is mounted turned about the axis by ``angle_rad``."""

    head: int
    at: Head
    angle_rad: float

    def head_shift_m(self, head: int, state: TableState) -> complex:
        """From where the head should be to where it is, metres."""
        if head != self.head:
            return 0j
        return self.at.point_m * (cmath.rect(1.0, self.angle_rad) - 1)
