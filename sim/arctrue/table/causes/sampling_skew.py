"""Models heads whose readings are not latched at the same instant."""

from __future__ import annotations

from dataclasses import dataclass

from arctrue.base.typed_content import Number
from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Given, Occasion, Random, Recipe
from arctrue.table.draws import later_head, sign


@dataclass(frozen=True, slots=True)
class SamplingSkew(Cause):
    """One head is latched later than the others by ``later_s``."""

    later_s: float
    head: int = 1

    def sampling_delay_s(self, head: int) -> float:
        """Return −``later_s`` for this head, because its reading is newer than those of the
        others."""
        return -self.later_s if head == self.head else 0.0


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    us: Number

    def physical(self, lines: int) -> SamplingSkew:
        """Return the cause that these values describe."""
        return SamplingSkew(self.us * 1e-6)


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    later_s = sign(random) * size * 1e-6
    return [SamplingSkew(later_s, later_head(random, occasion))]


DECLARATION = Declaration(
    SamplingSkew,
    values=Values,
    recipes=(
        Recipe(
            name="timing_skew",
            unit="us",
            low=1.0,
            high=20.0,
            draw=draw,
            rank=7,
            coefficients=1,
        ),
    ),
)
