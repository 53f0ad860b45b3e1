"""Models the entity ``head_watch``, which detects a failed head, clock by clock."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from arctrue.generated.number_formats import (
    WATCH_AHEAD_MAX,
    WATCH_INTERVAL_BITS,
    WATCH_READINGS,
    WATCH_SETTLE_CLOCKS,
)

STEP_COUNTS: Final = 32
"""Limit of a step for heads on a radius of 100 mm at 2²⁴ counts. An axis that moves by 0.5 µm
changes a reading by 0.5 µm / 100 mm = 1.03″ = 13.35 counts, and a difference of two readings by up
to 26.7 counts. An eccentricity of 37.7 µm adds a sine with an amplitude of up to 2 · 37.7 µm / 100
mm = 155.5″ to the difference. In 1.31 ms (8 intervals) at 90°/s this sine changes by up to 155.5″ ·
2 sin(90°/s · 1.31 ms / 2) = 0.32″ = 4.1 counts. Rounding adds 1 count."""


class FailoverCause(IntEnum):
    """Names of the bits of ``causes``, in the order of the bits in the register ``failover``."""

    ILLEGAL = 0
    OVERSPEED = 1
    SWALLOWED = 2
    MISSING_EDGES = 3
    STEP = 4
    INDEX = 5


def stepped_head(moved: NDArray[np.int64], limit: int) -> int | None:
    """Return the only head (numbered from 0) for which all other heads have moved by equal amounts.

    ``moved`` (heads,): changes of the readings, all relative to the same reading. Changes count as
    equal if they differ by less than ``limit`` counts. The function returns None if no head or
    several heads meet this condition, or if ``limit`` is 0.
    """
    candidates = [
        head
        for head in range(len(moved))
        if all(
            abs(int(moved[first] - moved[second])) < limit
            for first, second in itertools.combinations(range(len(moved)), 2)
            if head not in (first, second)
        )
    ]
    return candidates[0] if limit and len(candidates) == 1 else None


@dataclass
class StepSearch:
    """Compares the readings with those of 7 to 8 intervals earlier; one call is one clock."""

    heads: int
    interval_bits: int = WATCH_INTERVAL_BITS
    stored: list[NDArray[np.int64]] = field(default_factory=list)
    elapsed: int = 0
    settling: int = WATCH_SETTLE_CLOCKS
    phase: int = 0
    moved: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def clock(self, differences: NDArray[np.int64], limit: int, *, restart: bool) -> int | None:
        """Return the value of ``stepped`` after this clock."""
        found = None
        pairs = self.heads * (self.heads - 1) // 2
        begun = bool(self.stored)
        if self.phase == 0:
            if begun:
                self.moved = differences - self.stored[0]
                self.phase = 1
        elif self.phase <= pairs:
            self.phase += 1
        else:
            found = stepped_head(self.moved, limit)
            self.phase = 0
        if self.settling == 1 or (begun and self.elapsed == (1 << self.interval_bits) - 1):
            self.stored = [*self.stored, differences.copy()][-WATCH_READINGS:]
        self.elapsed = (self.elapsed + 1) % (1 << self.interval_bits)
        self.settling = max(self.settling - 1, 0)
        if restart:
            self.stored, self.settling, self.elapsed, self.phase = [], WATCH_SETTLE_CLOCKS, 0, 0
            return None
        return found


@dataclass
class MissingEdges:
    """Holds for every pair of heads how many counts the second head has moved since the last edge
    of the first head; one call is one clock."""

    heads: int
    ahead: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 0), dtype=np.int64))

    def __post_init__(self) -> None:
        """Set the state of a table at rest."""
        self.ahead = np.zeros((self.heads, self.heads), dtype=np.int64)

    def clock(self, steps: NDArray[np.int64], limit: int, *, watching: bool) -> NDArray[np.bool_]:
        """Return the value of ``dead`` after this clock; ``steps`` (heads,) are -1, 0 or 1."""
        reached = (np.abs(self.ahead) >= limit) | np.eye(self.heads, dtype=bool)
        looks = watching and limit > 0
        dead: NDArray[np.bool_] = np.logical_and(reached.all(axis=1), looks)
        self.ahead = np.clip(self.ahead + steps, -WATCH_AHEAD_MAX, WATCH_AHEAD_MAX)
        self.ahead[(steps != 0) | (not watching)] = 0
        return dead
