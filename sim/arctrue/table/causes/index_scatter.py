"""Models an index mark that each head detects at another count in every run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Occasion, Random, Recipe


@dataclass(frozen=True, slots=True)
class IndexScatter(Cause):
    """Each head detects its index mark in each run with an error from −``counts`` to ``counts``, a
    uniform whole number."""

    counts: int

    def index_shift_counts(self, random: np.random.Generator) -> int:
        """Draw a uniform whole number from −counts to counts."""
        return int(random.integers(-self.counts, self.counts + 1))

    def index_variance_counts2(self) -> float:
        """Return the variance of the uniform whole number: counts·(counts + 1)/3."""
        return self.counts * (self.counts + 1) / 3.0


def draw(size: float, _: Random, __: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [IndexScatter(round(size))]


DECLARATION = Declaration(
    IndexScatter,
    recipes=(
        Recipe(
            name="index_scatter",
            unit="counts",
            low=1.0,
            high=3.0,
            draw=draw,
            rank=36,
            kind="noise",
        ),
    ),
)
