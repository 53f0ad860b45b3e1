"""Models a bracket that sticks while friction loads it, and then slips."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.base.typed_content import Number
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Angles, Cause
from arctrue.table.declaration import (
    Declaration,
    Given,
    HeadNumber,
    Occasion,
    Random,
    Recipe,
    rising,
)
from arctrue.table.draws import any_head, instants
from arctrue.table.rotary_table import HEADS
from arctrue.table.state import TableState
from arctrue.table.turned_head import TurnedHead


@dataclass(frozen=True, slots=True)
class StickingBracket(TurnedHead):
    """Between two slips the head creeps along the scale at a constant rate; at each slip it jumps
    back.

    The head slips at the instants ``slips_s``, which are in rising order. In an interval of mean
    length the head creeps from −angle to +angle; in a longer interval it creeps farther.
    """

    angle_rad: float
    slips_s: tuple[float, ...]

    def turn_rad(self, state: TableState) -> Angles | float:
        """Return the angle by which the head is turned about the axis, radians, shape ``(n,)``."""
        slips = np.asarray(self.slips_s)
        since = np.searchsorted(slips, state.time_s, side="right") - 1
        waited_s = state.time_s - slips[np.maximum(since, 0)]
        return np.asarray(self.angle_rad * (2.0 * waited_s / np.diff(slips).mean() - 1.0))


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    head: HeadNumber
    arcsec: Number
    slips_s: tuple[Number, ...]

    def __post_init__(self) -> None:
        """Raise ValueError for fewer than two instants, and for instants that do not rise."""
        rising("slips_s", self.slips_s, 2)

    def physical(self, lines: int) -> StickingBracket:
        """Return the cause that these values describe."""
        head, angle = self.head - 1, self.arcsec * RAD_PER_ARCSEC
        return StickingBracket(head, HEADS[head], angle, self.slips_s)


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    head, mean_s = any_head(random, occasion), float(random.uniform(1.0, 6.0))
    slips = instants(mean_s, random, occasion)
    return [StickingBracket(head, occasion.heads[head], size * RAD_PER_ARCSEC, slips)]


DECLARATION = Declaration(
    StickingBracket,
    values=Values,
    recipes=(
        Recipe(
            name="sticking_bracket",
            unit="arcsec",
            low=0.1,
            high=1.0,
            draw=draw,
            rank=25,
            kind="stranger",
            coefficients=1,
            places=200,
        ),
    ),
)
