"""The centre of the disc wanders with heat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.causes.base import PhysicalEffect, Points
from arctrue.table.conditions import heating_k
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class ThermalCentre(PhysicalEffect):
    """The hub grows to one side and pushes the disc ``rate_m_per_k`` (x + jy, table frame)."""

    rate_m_per_k: complex

    def disc_shift_m(self, state: TableState) -> Points:
        """Displacement in the frame of the turning table, metres, shape ``(n,)``."""
        return np.asarray(self.rate_m_per_k * heating_k(state))
