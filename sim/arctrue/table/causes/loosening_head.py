"""Models a head whose screws become loose."""

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
class LooseningHead(TurnedHead):
    """The head jumps at irregular instants between two stops; the play between the stops grows with
    time.

    The stops are at ±``angle_rad``·(time/last instant); successive jumps lead to opposite stops.
    """

    angle_rad: float
    knocks_s: tuple[float, ...]

    def turn_rad(self, state: TableState) -> Angles | float:
        """Return the angle by which the head is turned about the axis, radians, shape ``(n,)``."""
        knocks = np.asarray(self.knocks_s)
        side = np.where(np.searchsorted(knocks, state.time_s) % 2 == 0, 1.0, -1.0)
        return np.asarray(self.angle_rad * side * state.time_s / knocks[-1])


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    head: HeadNumber
    arcsec: Number
    knocks_s: tuple[Number, ...]

    def __post_init__(self) -> None:
        """Raise ValueError for a list without instants, and for instants that do not rise."""
        rising("knocks_s", self.knocks_s, 1)

    def physical(self, lines: int) -> LooseningHead:
        """Return the cause that these values describe."""
        head, angle = self.head - 1, self.arcsec * RAD_PER_ARCSEC
        return LooseningHead(head, HEADS[head], angle, self.knocks_s)


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    head, mean_s = any_head(random, occasion), float(random.uniform(2.0, 8.0))
    knocks = instants(mean_s, random, occasion)
    return [LooseningHead(head, occasion.heads[head], size * RAD_PER_ARCSEC, knocks)]


DECLARATION = Declaration(
    LooseningHead,
    values=Values,
    recipes=(
        Recipe(
            name="loosening_head",
            unit="arcsec",
            low=0.3,
            high=3.0,
            draw=draw,
            rank=26,
            kind="stranger",
            coefficients=1,
            places=200,
        ),
    ),
)
