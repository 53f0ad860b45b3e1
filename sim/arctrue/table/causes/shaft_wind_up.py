"""The shaft between disc and table top winds up under friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.cause import Cause
from arctrue.table.conditions import Conditions


@dataclass(frozen=True, slots=True)
class ShaftWindUp(Cause):
    """Friction turns the disc against the table top by ±``angle_rad``, by the direction."""

    angle_rad: float

    def disc_turn_rad(self, conditions: Conditions) -> NDArray[np.float64]:
        """Turn of the disc, shape ``(n,)``."""
        return np.asarray(self.angle_rad * conditions.direction)
