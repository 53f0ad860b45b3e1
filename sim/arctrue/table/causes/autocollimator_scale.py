"""Models an autocollimator with a wrong scale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.typed_content import Number
from arctrue.table.cause import Cause, Stations
from arctrue.table.declaration import Declaration, Given, Occasion, Random, Recipe
from arctrue.table.draws import sign


@dataclass(frozen=True, slots=True)
class AutocollimatorScale(Cause):
    """The autocollimator's scale is wrong: the error is ``gain`` times the reading."""

    gain: float

    def instrument_error_rad(
        self, stations: Stations, deviation_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return gain × deviation, shape ``(n,)``."""
        return self.gain * deviation_rad


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    percent: Number

    def physical(self, lines: int) -> AutocollimatorScale:
        """Return the cause that these values describe."""
        return AutocollimatorScale(self.percent / 100)


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [AutocollimatorScale(sign(random) * size / 100)]


DECLARATION = Declaration(
    AutocollimatorScale,
    values=Values,
    recipes=(
        Recipe(
            name="autocollimator_gain",
            unit="percent",
            low=0.1,
            high=1.0,
            draw=draw,
            rank=16,
            coefficients=1,
        ),
    ),
)
