"""A drive whose speed swings about the one that it was asked for."""

from __future__ import annotations

from dataclasses import dataclass, replace

from arctrue.table.causes.cause import Cause
from arctrue.table.motion import Motion


@dataclass(frozen=True, slots=True)
class SwingingSpeed(Cause):
    """The speed swings by a share of itself, ``order`` times a turn: unbalance, cogging."""

    share: float
    order: int
    phase_rad: float

    def driven(self, motion: Motion) -> Motion:
        """The motion with the ripple whose speed swings by the share."""
        return replace(
            motion,
            ripple_rad=self.share / self.order,
            ripple_order=self.order,
            ripple_phase_rad=self.phase_rad,
        )
