"""The teeth of the drive push the table, one by one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.cause import Cause
from arctrue.table.conditions import Conditions


@dataclass(frozen=True, slots=True)
class GearMesh(Cause):
    """Each tooth in mesh twists the shaft between disc and table top, ``teeth``·k times a turn.

    Disc and heads turn together, so the heads agree; only the reference on top sees it.
    """

    teeth: int
    amplitudes_rad: tuple[float, ...]
    """For k = 1, 2, …"""
    phases_rad: tuple[float, ...]

    def disc_turn_rad(self, conditions: Conditions) -> NDArray[np.float64]:
        """Turn of the disc, shape ``(n,)``."""
        turn = np.zeros_like(conditions.angle_rad)
        pairs = zip(self.amplitudes_rad, self.phases_rad, strict=True)
        for multiple, (amplitude, phase) in enumerate(pairs, start=1):
            turn += amplitude * np.cos(multiple * self.teeth * conditions.angle_rad + phase)
        return turn
