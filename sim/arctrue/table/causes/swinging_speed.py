"""Models a drive whose speed varies about the requested speed."""

from __future__ import annotations

from dataclasses import dataclass, replace

from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Occasion, Random, Recipe
from arctrue.table.draws import angle
from arctrue.table.motion import Motion


@dataclass(frozen=True, slots=True)
class SwingingSpeed(Cause):
    """The speed varies by ± ``share`` of the requested speed, ``order`` times a turn, because of
    unbalance or cogging."""

    share: float
    order: int
    phase_rad: float

    def driven(self, motion: Motion) -> Motion:
        """Return the requested motion with a ripple of the angle; the ripple varies the speed by
        the share."""
        return replace(
            motion,
            ripple_rad=self.share / self.order,
            ripple_order=self.order,
            ripple_phase_rad=self.phase_rad,
        )


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [SwingingSpeed(size / 100, int(random.integers(1, 9)), angle(random))]


DECLARATION = Declaration(
    SwingingSpeed,
    recipes=(
        Recipe(
            name="swinging_speed",
            unit="percent",
            low=0.5,
            high=8.0,
            draw=draw,
            rank=40,
            kind="noise",
        ),
    ),
)
