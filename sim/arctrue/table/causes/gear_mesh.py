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

    A gear that is not centred has a pitch that wobbles once a turn: the place in the mesh is
    teeth·θ + wobble·sin(θ + wobble phase), which puts side lines at teeth ± 1.
    Disc and heads turn together, so the heads agree; only the reference on top sees it.
    """

    teeth: int
    amplitudes_rad: tuple[float, ...]
    """For k = 1, 2, …"""
    phases_rad: tuple[float, ...]
    wobble_rad: float = 0.0
    """In radians of the mesh."""
    wobble_phase_rad: float = 0.0

    def disc_turn_rad(self, conditions: Conditions) -> NDArray[np.float64]:
        """Turn of the disc, shape ``(n,)``."""
        turn = np.zeros_like(conditions.angle_rad)
        wobble = self.wobble_rad * np.sin(conditions.angle_rad + self.wobble_phase_rad)
        mesh = self.teeth * conditions.angle_rad + wobble
        pairs = zip(self.amplitudes_rad, self.phases_rad, strict=True)
        for multiple, (amplitude, phase) in enumerate(pairs, start=1):
            turn += amplitude * np.cos(multiple * mesh + phase)
        return turn
