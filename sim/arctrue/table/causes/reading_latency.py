"""Models readings of both heads that are already old when they are used."""

from __future__ import annotations

from dataclasses import dataclass

from arctrue.base.typed_content import NotNegative
from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Given, Occasion, Random, Recipe


@dataclass(frozen=True, slots=True)
class ReadingLatency(Cause):
    """A filter and the data transfer delay the readings of both heads by ``delay_s``."""

    delay_s: float

    def sampling_delay_s(self, head: int) -> float:
        """Return the age of each reading, seconds."""
        return self.delay_s


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    us: NotNegative

    def physical(self, lines: int) -> ReadingLatency:
        """Return the cause that these values describe."""
        return ReadingLatency(self.us * 1e-6)


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [ReadingLatency(size * 1e-6)]


DECLARATION = Declaration(
    ReadingLatency,
    values=Values,
    recipes=(
        Recipe(
            name="latency",
            unit="us",
            low=2.0,
            high=50.0,
            draw=draw,
            rank=8,
            coefficients=1,
        ),
    ),
)
