"""Models a counter that loses or gains counts at one instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.declaration import ROWS, Declaration, Occasion, Random, Recipe
from arctrue.table.draws import any_head, sign


@dataclass(frozen=True, slots=True)
class LostCounts(Cause):
    """The counter of one head is wrong by ``counts`` from the time ``instant_s`` of one run on.

    The next run begins at the index mark, which corrects the counter. If the counter does not use
    its index (``for_good``), it keeps the error in all later runs.
    """

    head: int
    run: int
    instant_s: float
    """Time of the loss since the start of the run."""
    counts: int
    for_good: bool = False

    def gained_counts(self, head: int, conditions: Conditions) -> NDArray[np.int64] | int:
        """Return the number of gained counts, negative for lost counts, shape ``(n,)``."""
        if head != self.head:
            return 0
        later = conditions.run > self.run if self.for_good else False
        after = (conditions.run == self.run) & (conditions.since_run_start_s >= self.instant_s)
        return np.where(after | later, self.counts, 0).astype(np.int64)


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    run = int(random.integers(max(len(occasion.durations_s), 1)))
    instant = float(random.uniform(0.15, 0.85)) * occasion.durations_s[run]
    counts = int(sign(random)) * max(1, round(size))
    return [LostCounts(any_head(random, occasion), run, instant, counts)]


DECLARATION = Declaration(
    LostCounts,
    recipes=(
        Recipe(
            name="count_slip",
            unit="counts",
            low=4.0,
            high=64.0,
            draw=draw,
            rank=11,
            coefficients=1,
            places=4 * np.log(ROWS),
        ),
    ),
)
