"""The heads are not latched at the same instant."""

from __future__ import annotations

from dataclasses import dataclass

from arctrue.table.causes.cause import Cause


@dataclass(frozen=True, slots=True)
class SamplingSkew(Cause):
    """Head 2 is latched ``later_s`` after head 1."""

    later_s: float

    def sampling_delay_s(self, head: int) -> float:
        """A later latch is a reading that is younger than head 1's."""
        return -self.later_s if head == 1 else 0.0
