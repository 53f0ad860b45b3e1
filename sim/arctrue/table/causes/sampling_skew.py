"""Models heads whose readings are not latched at the same instant."""

from __future__ import annotations

from dataclasses import dataclass

from arctrue.base.typed_content import Number
from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Given, Occasion, Random, Recipe
from arctrue.table.draws import sign


@dataclass(frozen=True, slots=True)
class SamplingSkew(Cause):
    """Head 2 is latched later than head 1 by ``later_s``."""

    later_s: float

    def sampling_delay_s(self, head: int) -> float:
        """Return −``later_s`` for head 2, because its reading is newer than that of head 1."""
        return -self.later_s if head == 1 else 0.0


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    us: Number

    def physical(self, lines: int) -> SamplingSkew:
        """Return the cause that these values describe."""
        return SamplingSkew(self.us * 1e-6)


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [SamplingSkew(sign(random) * size * 1e-6)]


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
