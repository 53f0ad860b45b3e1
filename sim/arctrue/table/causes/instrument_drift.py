"""Models a reference instrument whose stand drifts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.typed_content import Number
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause, Stations
from arctrue.table.declaration import Declaration, Given, Occasion, Random, Recipe
from arctrue.table.draws import sign

DRIFT_HOURS = 12.0
DRIFT_KNOT_S = 60.0


@dataclass(frozen=True, slots=True)
class InstrumentDrift(Cause):
    """The reference instrument turns during the measurement because the temperature of its stand
    changes.

    Its angle is a steady rate plus a curve. The curve has a value at each knot, is linear between
    the knots, and is constant before the first and after the last knot.
    """

    rate_rad_s: float
    knots_s: tuple[float, ...] = (0.0,)
    turns_rad: tuple[float, ...] = (0.0,)

    def instrument_error_rad(
        self, stations: Stations, deviation_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return rate × time plus the value of the curve, shape ``(n,)``."""
        time_s = stations.conditions.time_s
        wandering = np.interp(time_s, self.knots_s, self.turns_rad)
        return np.asarray(self.rate_rad_s * time_s + wandering)


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    arcsec_per_h: Number

    def physical(self, lines: int) -> InstrumentDrift:
        """Return the cause that these values describe."""
        return InstrumentDrift(self.arcsec_per_h * RAD_PER_ARCSEC / 3600)


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    rate = sign(random) * size * RAD_PER_ARCSEC / 3600
    # The curve is a random walk; the standard deviation of its step is a fifth of the change that
    # the steady rate makes between two knots.
    knots_s = np.arange(0.0, DRIFT_HOURS * 3600.0, DRIFT_KNOT_S)
    steps = random.normal(0.0, 0.2 * abs(rate) * DRIFT_KNOT_S, knots_s.size - 1)
    turns = np.concatenate([[0.0], np.cumsum(steps)])
    return [InstrumentDrift(rate, tuple(knots_s.tolist()), tuple(turns.tolist()))]


DECLARATION = Declaration(
    InstrumentDrift,
    values=Values,
    recipes=(
        Recipe(
            name="reference_drift",
            unit="arcsec/h",
            low=0.3,
            high=3.0,
            draw=draw,
            rank=17,
            coefficients=1,
        ),
    ),
)
