"""Models a head that is mounted at another stator angle than the drawing states."""

from __future__ import annotations

import cmath
from dataclasses import dataclass

from arctrue.base.typed_content import Number
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Given, HeadNumber, Occasion, Random, Recipe
from arctrue.table.draws import later_head, sign
from arctrue.table.head import Head
from arctrue.table.rotary_table import HEADS
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class BracketTurn(Cause):
    """The bracket of one head is mounted at a place rotated by ``angle_rad`` about the axis."""

    head: int
    at: Head
    angle_rad: float

    def head_shift_m(self, head: int, state: TableState) -> complex:
        """Return the shift from the head's nominal to its true position, metres."""
        if head != self.head:
            return 0j
        return self.at.point_m * (cmath.rect(1.0, self.angle_rad) - 1)


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    arcsec: Number
    head: HeadNumber = 2

    def physical(self, lines: int) -> BracketTurn:
        """Return the cause that these values describe."""
        return BracketTurn(self.head - 1, HEADS[self.head - 1], self.arcsec * RAD_PER_ARCSEC)


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    # α becomes larger if head 2 is rotated by a negative angle: docs/architecture.md, "Head
    # geometry".
    angle, head = -sign(random) * size * RAD_PER_ARCSEC, later_head(random, occasion)
    return [BracketTurn(head, occasion.heads[head], angle)]


DECLARATION = Declaration(
    BracketTurn,
    values=Values,
    recipes=(
        Recipe(
            name="head_angle_error",
            unit="arcsec",
            low=2.0,
            high=60.0,
            draw=draw,
            rank=1,
            coefficients=1,
        ),
    ),
)
