"""Holds the weights, offsets and carrier of the mean of two to four heads in the formats of the
gateware."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from arctrue.generated.number_formats import (
    HEAD_OFFSET_FRACTION,
    HEAD_OFFSET_WIDTH,
    HEAD_WEIGHT_FRACTION,
    HEAD_WEIGHT_WIDTH,
    HEADS_MAX,
)

WEIGHT_ONE: Final = 1 << HEAD_WEIGHT_FRACTION
WEIGHT_LIMIT: Final = 1 << (HEAD_WEIGHT_WIDTH - 1)
OFFSET_ONE: Final = 1 << HEAD_OFFSET_FRACTION
DELAY_MOST_CLOCKS: Final = 255


@dataclass(frozen=True)
class MeanSet:
    """Parameters of the mean θ = r_s + Σ wᵢ·(rᵢ − r_s) − E(r_s) with rᵢ = Rᵢ − oᵢ, one entry per
    head. Rᵢ is the reading of head i, E the correction by the lanes.

    ``weights`` in 2⁻¹⁶, with the sum 65536. ``offsets`` oᵢ in 1/16 count. ``carrier``: number s of
    the head whose counts the output follows, 1 for head 1. ``missing``: number of the head that is
    left out, 0 for none. ``delays_clocks``: delay of A, B and Z of each head. Raises ValueError for
    words that the gateware cannot hold, or that define no mean.
    """

    weights: tuple[int, ...]
    offsets: tuple[int, ...]
    carrier: int = 1
    missing: int = 0
    delays_clocks: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        """Raise ValueError for a word that does not fit its format, or words that define no
        mean."""
        if not self.delays_clocks:
            object.__setattr__(self, "delays_clocks", (0,) * self.heads)
        if not 2 <= self.heads <= HEADS_MAX:
            raise ValueError(f"heads: {self.heads}, the gateware has 2 to {HEADS_MAX}")
        if not len(self.offsets) == len(self.delays_clocks) == self.heads:
            raise ValueError(
                f"expected one weight, offset and delay per head: found {self.heads} weights, "
                f"{len(self.offsets)} offsets, {len(self.delays_clocks)} delays"
            )
        for head, weight in enumerate(self.weights, start=1):
            if not -WEIGHT_LIMIT <= weight < WEIGHT_LIMIT:
                raise ValueError(
                    f"weight of head {head}: {weight / WEIGHT_ONE:g}, the gateware holds -2 to "
                    "less than 2; choose other places of the heads"
                )
        if sum(self.weights) != WEIGHT_ONE:
            raise ValueError(
                f"weights: expected a sum of {WEIGHT_ONE} (1.0), found {sum(self.weights)}"
            )
        if not 0 <= self.missing <= self.heads:
            raise ValueError(f"missing: head {self.missing}, there are heads 1 to {self.heads}")
        if self.missing and self.weights[self.missing - 1]:
            raise ValueError(f"weight of head {self.missing}: expected 0 where it is missing")
        if not 1 <= self.carrier <= self.heads or self.carrier == self.missing:
            raise ValueError(
                f"carrier: head {self.carrier}, expected 1 to {self.heads} except the missing head"
            )
        for head, offset in enumerate(self.offsets, start=1):
            if not 0 <= offset < 1 << HEAD_OFFSET_WIDTH:
                raise ValueError(
                    f"offset of head {head}: word {offset}, expected 0 to 2^{HEAD_OFFSET_WIDTH} - 1"
                )
        for head, delay in enumerate(self.delays_clocks, start=1):
            if not 0 <= delay <= DELAY_MOST_CLOCKS:
                raise ValueError(
                    f"delay of head {head}: {delay} clocks, expected 0 to {DELAY_MOST_CLOCKS}"
                )

    @property
    def heads(self) -> int:
        """Number of heads that the gateware must have for this mean."""
        return len(self.weights)

    @property
    def used(self) -> tuple[bool, ...]:
        """Whether the index of each head is needed: true for all heads except the missing one."""
        return tuple(head != self.missing for head in range(1, self.heads + 1))

    def words(self) -> list[int]:
        """Return the words of the register window ``mean`` up to ``choice``, as unsigned 32-bit
        numbers."""
        empty = [0] * (HEADS_MAX - self.heads)
        used = sum(1 << place for place, is_used in enumerate(self.used) if is_used)
        return [
            *self.offsets,
            *empty,
            *(weight & 0xFFFF_FFFF for weight in self.weights),
            *empty,
            (self.carrier - 1) | used << 4,
        ]
