"""Models noise of the readings that is independent from row to row."""

from __future__ import annotations

from dataclasses import dataclass

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause, Stations
from arctrue.table.conditions import Conditions
from arctrue.table.declaration import Declaration, Occasion, Random, Recipe
from arctrue.table.noise import Noise


@dataclass(frozen=True, slots=True)
class WhiteNoise(Cause):
    """White noise has one standard deviation for each head's reading and another one for the
    reference instrument."""

    head_rad: float = 0.0
    instrument_rad: float = 0.0

    def head_noise(self, head: int, conditions: Conditions) -> Noise | None:
        """Return noise with the same standard deviation in every row."""
        return Noise.white(self.head_rad, conditions.time_s.size) if self.head_rad else None

    def instrument_noise(self, stations: Stations) -> Noise | None:
        """Return noise with the same standard deviation in every row."""
        rows = stations.conditions.time_s.size
        return Noise.white(self.instrument_rad, rows) if self.instrument_rad else None


def draw(size: float, _: Random, __: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [WhiteNoise(head_rad=size * RAD_PER_ARCSEC)]


DECLARATION = Declaration(
    WhiteNoise,
    recipes=(
        Recipe(
            name="white",
            unit="arcsec",
            low=0.02,
            high=0.5,
            draw=draw,
            rank=29,
            kind="noise",
        ),
    ),
)
