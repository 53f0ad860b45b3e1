"""The shaft between disc and table top winds up under friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.cause import Cause
from arctrue.table.conditions import Conditions


@dataclass(frozen=True, slots=True)
class ShaftWindUp(Cause):
    """Friction turns the disc against the table top by ±``angle_rad``, along a loop.

    After a reversal the wind-up goes over from the other side within a stroke, as Dahl's model of
    dry friction has it: direction × angle × (1 − 2·exp(−travel/stroke)). With a stroke of 0, or
    where the travel since the reversal is not known, it is direction × angle.
    """

    angle_rad: float
    stroke_rad: float = 0.0

    def disc_turn_rad(self, conditions: Conditions) -> NDArray[np.float64]:
        """Turn of the disc, shape ``(n,)``."""
        turn = self.angle_rad * conditions.direction
        travel = conditions.since_reversal_rad
        if self.stroke_rad > 0.0 and travel is not None:
            turn = turn * (1.0 - 2.0 * np.exp(-travel / self.stroke_rad))
        return np.asarray(turn)
