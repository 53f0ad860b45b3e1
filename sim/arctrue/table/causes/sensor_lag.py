"""Models a temperature sensor that follows the temperature of the table with a delay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Occasion, Random, Recipe
from arctrue.table.temperature import TemperatureCourse


@dataclass(frozen=True, slots=True)
class SensorLag(Cause):
    """The sensor has a heat capacity and follows the temperature with a first-order lag of this
    time constant."""

    constant_s: float

    def shown_temperature_c(
        self, course: TemperatureCourse, time_s: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the temperature that the sensor shows, °C, shape ``(n,)``."""
        return course.lagging(time_s, self.constant_s)


def draw(size: float, _: Random, __: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    return [SensorLag(size * 60.0)]


DECLARATION = Declaration(
    SensorLag,
    recipes=(
        Recipe(
            name="sensor_lag",
            unit="minutes",
            low=0.5,
            high=10.0,
            draw=draw,
            rank=37,
            kind="noise",
        ),
    ),
)
