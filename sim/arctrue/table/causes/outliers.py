"""Models single wrong rows, for example due to a disturbance on a wire or a flipped bit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.conditions import Conditions
from arctrue.table.declaration import Declaration, Occasion, Random, Recipe

FREEDOM = 2.0
"""Degrees of freedom of Student's t: 2, for which the variance is infinite, as observed for real
outliers."""

OUTLIER_ARCSEC = 2.0
"""Scale of Student's t, about twenty times the typical noise."""


@dataclass(frozen=True, slots=True)
class Outliers(Cause):
    """Any row of any head is wrong with a given probability; the error of a wrong row follows
    Student's t."""

    probability: float
    scale_rad: float

    def struck_rad(
        self, head: int, conditions: Conditions, random: np.random.Generator
    ) -> NDArray[np.float64]:
        """Return the errors of the wrong rows, and 0 for all other rows, shape ``(n,)``."""
        rows = conditions.time_s.size
        struck = random.random(rows) < self.probability
        return np.where(struck, self.scale_rad * random.standard_t(FREEDOM, rows), 0.0)


def draw(size: float, _: Random, __: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [Outliers(size / 100, OUTLIER_ARCSEC * RAD_PER_ARCSEC)]


DECLARATION = Declaration(
    Outliers,
    recipes=(
        Recipe(
            name="outliers",
            unit="percent",
            low=0.01,
            high=1.0,
            draw=draw,
            rank=35,
            kind="noise",
        ),
    ),
)
