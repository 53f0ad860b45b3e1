"""The disc creeps on its hub as the table turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.conditions import travelled_turns
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class CreepingCentre(PhysicalEffect):
    """A clamp gives way: each turn pushes the disc ``rate_m`` (x + jy, table frame) further."""

    rate_m: complex

    def disc_shift_m(self, state: TableState) -> Points:
        """Displacement in the frame of the turning table, metres, shape ``(n,)``.

        Raises ValueError without the travel.
        """
        return np.asarray(self.rate_m * travelled_turns(state))
