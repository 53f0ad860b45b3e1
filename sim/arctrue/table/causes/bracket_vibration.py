"""Models a bracket that vibrates at its own frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number, Positive
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Angles, Cause
from arctrue.table.conditions import conditions_of
from arctrue.table.declaration import (
    NYQUIST_HZ,
    Declaration,
    Given,
    HeadNumber,
    Occasion,
    Random,
    Recipe,
)
from arctrue.table.draws import angle, any_head
from arctrue.table.rotary_table import HEADS
from arctrue.table.state import TableState
from arctrue.table.turned_head import TurnedHead


@dataclass(frozen=True, slots=True)
class BracketVibration(TurnedHead):
    """The head vibrates along the scale with ``amplitude_rad``, an angle at the axis.

    The phase of the vibration does not depend on the table's angle: each run has a phase of its
    own; if there are more runs than phases, the phases repeat.
    """

    amplitude_rad: float
    frequency_hz: float
    phases_rad: tuple[float, ...] = (0.0,)

    def turn_rad(self, state: TableState) -> Angles | float:
        """Return the angle by which the head is turned about the axis, radians, shape ``(n,)``."""
        run = conditions_of(state).run % len(self.phases_rad)
        phase = 2 * np.pi * self.frequency_hz * state.time_s + np.asarray(self.phases_rad)[run]
        return np.asarray(self.amplitude_rad * np.sin(phase))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    head: HeadNumber
    arcsec: Number
    hz: Positive
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> BracketVibration:
        """Return the cause that these values describe."""
        head = self.head - 1
        phases = (math.radians(self.phase_deg),)
        return BracketVibration(head, HEADS[head], self.arcsec * RAD_PER_ARCSEC, self.hz, phases)


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    phases = tuple(angle(random) for _ in range(max(len(occasion.durations_s), 1)))
    frequency, head = float(random.uniform(3.0, 120.0)), any_head(random, occasion)
    return [BracketVibration(head, occasion.heads[head], size * RAD_PER_ARCSEC, frequency, phases)]


DECLARATION = Declaration(
    BracketVibration,
    values=Values,
    recipes=(
        Recipe(
            name="vibration",
            unit="arcsec",
            low=0.1,
            high=1.0,
            draw=draw,
            rank=5,
            coefficients=8,
            places=36 * NYQUIST_HZ,
        ),
    ),
)
