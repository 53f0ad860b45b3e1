"""Models rows that were not recorded because the data link was busy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.declaration import Declaration, Occasion, Random, Recipe
from arctrue.table.draws import log_uniform


@dataclass(frozen=True, slots=True)
class TimeGaps(Cause):
    """Stretches of rows are missing: about the share ``share`` of all rows, in stretches of
    ``mean_rows`` rows on average.

    A stretch begins at every row with the same probability, and ends with another constant
    probability. The first and the last row of a run are always present.
    """

    share: float
    mean_rows: float

    def kept_rows(self, conditions: Conditions, random: np.random.Generator) -> NDArray[np.bool_]:
        """Return True for each row that is recorded, shape ``(n,)``."""
        rows = conditions.run.size
        number = random.poisson(self.share * rows / self.mean_rows)
        begins = random.integers(0, rows, number)
        lengths = random.geometric(1.0 / self.mean_rows, number)
        missing = np.zeros(rows + 1, dtype=np.int64)
        np.add.at(missing, begins, 1)
        np.add.at(missing, np.minimum(begins + lengths, rows), -1)
        kept: NDArray[np.bool_] = np.cumsum(missing[:-1]) == 0
        borders = np.diff(conditions.run) != 0
        kept[np.append(borders, True)] = True
        kept[np.concatenate([[True], borders])] = True
        return kept


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [TimeGaps(size / 100, log_uniform(3.0, 100.0, random))]


DECLARATION = Declaration(
    TimeGaps,
    recipes=(
        Recipe(
            name="gaps",
            unit="percent",
            low=0.5,
            high=20.0,
            draw=draw,
            rank=39,
            kind="noise",
        ),
    ),
)
