"""Defines the base class of causes in which a bracket turns its head about the axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.cause import Angles, Cause, Points
from arctrue.table.head import Head
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class TurnedHead(Cause):
    """Base class of the causes that move one head along the scale; a subclass defines the angle."""

    head: int
    at: Head

    def turn_rad(self, state: TableState) -> Angles | float:
        """Return the angle by which the head is turned about the axis, radians, shape ``(n,)``."""
        raise NotImplementedError

    def head_shift_m(self, head: int, state: TableState) -> Points | complex:
        """Return the shift from the head's nominal to its true position, metres, shape ``(n,)``."""
        if head != self.head:
            return 0j
        return np.asarray(self.at.point_m * (np.exp(1j * self.turn_rad(state)) - 1))
