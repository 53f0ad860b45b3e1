"""Both readings are old when they are used."""

from __future__ import annotations

from dataclasses import dataclass

from arctrue.table.causes.cause import Cause


@dataclass(frozen=True, slots=True)
class ReadingLatency(Cause):
    """Filter and transfer take ``delay_s`` for both heads alike."""

    delay_s: float

    def sampling_delay_s(self, head: int) -> float:
        """How old the reading is."""
        return self.delay_s
