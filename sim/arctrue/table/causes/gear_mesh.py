"""Models the teeth of the drive, which push the table one by one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.typed_content import Number
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.declaration import Declaration, Given, Occasion, Order, Random, Recipe
from arctrue.table.draws import angle

GEAR_WOBBLE_RAD = 0.3
GEAR_TEETH = (62, 72, 90, 100, 120, 180, 225)
"""Numbers of teeth from which a draw selects; with 72 and 120 all 24 stations lie at the same point
of a tooth."""


@dataclass(frozen=True, slots=True)
class GearMesh(Cause):
    """The meshing teeth twist the shaft between disc and table top, ``teeth``·k times a turn.

    If the gear is not centred, its pitch varies once a turn: the angle in the mesh is teeth·θ +
    wobble·sin(θ + wobble phase), which adds the orders teeth ± 1.

    The twist turns the disc under both heads alike, so the heads agree; only the reference on the
    table top shows the twist.
    """

    teeth: float
    """Number of teeth that mesh per turn of the table; it is not whole if the gear turns faster
    than the table."""
    amplitudes_rad: tuple[float, ...]
    """Amplitude of the twist at each multiple k = 1, 2, … of ``teeth``."""
    phases_rad: tuple[float, ...]
    wobble_rad: float = 0.0
    """Amplitude of the pitch variation, as an angle in the meshing period."""
    wobble_phase_rad: float = 0.0

    def disc_turn_rad(self, conditions: Conditions) -> NDArray[np.float64]:
        """Return the angle of the disc relative to the table top, shape ``(n,)``."""
        turn = np.zeros_like(conditions.angle_rad)
        wobble = self.wobble_rad * np.sin(conditions.angle_rad + self.wobble_phase_rad)
        mesh = self.teeth * conditions.angle_rad + wobble
        pairs = zip(self.amplitudes_rad, self.phases_rad, strict=True)
        for multiple, (amplitude, phase) in enumerate(pairs, start=1):
            turn += amplitude * np.cos(multiple * mesh + phase)
        return turn


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    teeth: Order
    arcsec: Number
    phase_deg: Number = 0.0
    wobble_rad: Number = 0.0
    wobble_phase_deg: Number = 0.0

    def physical(self, lines: int) -> GearMesh:
        """Return the cause that these values describe."""
        return GearMesh(
            self.teeth,
            (self.arcsec * RAD_PER_ARCSEC,),
            (math.radians(self.phase_deg),),
            self.wobble_rad,
            math.radians(self.wobble_phase_deg),
        )


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    teeth = int(random.choice(GEAR_TEETH))
    phase, wobble = angle(random), float(random.uniform(0.0, GEAR_WOBBLE_RAD))
    return [GearMesh(teeth, (size * RAD_PER_ARCSEC,), (phase,), wobble, angle(random))]


DECLARATION = Declaration(
    GearMesh,
    values=Values,
    recipes=(
        Recipe(
            name="drive_gear_error",
            unit="arcsec",
            low=0.3,
            high=3.0,
            draw=draw,
            rank=13,
            coefficients=2,
        ),
    ),
)
