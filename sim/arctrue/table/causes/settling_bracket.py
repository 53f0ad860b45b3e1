"""Models a bracket that settles after the start of the measurement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number, Positive
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Angles, Cause
from arctrue.table.conditions import conditions_of
from arctrue.table.declaration import Declaration, Given, HeadNumber, Occasion, Random, Recipe
from arctrue.table.draws import later_head, sign
from arctrue.table.rotary_table import HEADS
from arctrue.table.state import TableState
from arctrue.table.turned_head import TurnedHead


@dataclass(frozen=True, slots=True)
class SettlingBracket(TurnedHead):
    """The bracket of one head creeps along the scale by angle·exp(−t/τ), an angle at the axis.

    With ``each_run`` the time counts from the start of every run, otherwise from the start of the
    first run.
    """

    angle_rad: float
    time_constant_s: float
    each_run: bool = False

    def turn_rad(self, state: TableState) -> Angles | float:
        """Return the angle by which the head is turned about the axis, radians, shape ``(n,)``."""
        conditions = conditions_of(state)
        since_s = conditions.since_run_start_s if self.each_run else conditions.time_s
        return np.asarray(self.angle_rad * np.exp(-since_s / self.time_constant_s))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    arcsec: Number
    time_constant_s: Positive
    head: HeadNumber = 2

    def physical(self, lines: int) -> SettlingBracket:
        """Return the cause that these values describe."""
        head, angle = self.head - 1, self.arcsec * RAD_PER_ARCSEC
        # With ``each_run`` the time since the start of the run includes pauses in full: see
        # course.py.
        return SettlingBracket(head, HEADS[head], angle, self.time_constant_s, each_run=True)


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    each_run = bool(random.integers(2))
    tau_s = float(random.uniform(4.0, 15.0) if each_run else random.uniform(20.0, 60.0))
    angle = sign(random) * size * RAD_PER_ARCSEC
    head = later_head(random, occasion)
    return [SettlingBracket(head, occasion.heads[head], angle, tau_s, each_run)]


DECLARATION = Declaration(
    SettlingBracket,
    values=Values,
    recipes=(
        Recipe(
            name="settling_bracket",
            unit="arcsec",
            low=0.5,
            high=3.0,
            draw=draw,
            rank=21,
            kind="parts",
            parts=("settling", "head2"),
            coefficients=1,
            places=6,
        ),
    ),
)
