"""Models a polygon whose faces deviate from their nominal angles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from arctrue.base.typed_content import Number
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause, Stations
from arctrue.table.declaration import Declaration, Given, Occasion, Random, Recipe
from arctrue.table.instruments.polygon import FACES


@dataclass(frozen=True, slots=True)
class PolygonFaces(Cause):
    """The direction of each face deviates from its nominal direction by an angle of its own."""

    errors_rad: tuple[float, ...]

    def instrument_error_rad(
        self, stations: Stations, deviation_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the error of the observed face, shape ``(n,)``."""
        return np.asarray(self.errors_rad)[stations.face % len(self.errors_rad)]


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    arcsec: Annotated[tuple[Number, ...], Meta(min_length=1)]

    def physical(self, lines: int) -> PolygonFaces:
        """Return the cause that these values describe."""
        return PolygonFaces(tuple(np.multiply(self.arcsec, RAD_PER_ARCSEC).tolist()))


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    errors = random.normal(0.0, size * RAD_PER_ARCSEC, FACES)
    return [PolygonFaces(tuple((errors - errors.mean()).tolist()))]


DECLARATION = Declaration(
    PolygonFaces,
    values=Values,
    recipes=(
        Recipe(
            name="polygon_face_error",
            unit="arcsec",
            low=0.1,
            high=0.5,
            draw=draw,
            rank=14,
            coefficients=23,
        ),
    ),
)
