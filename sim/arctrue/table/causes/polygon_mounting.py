"""Models a polygon that is mounted off the axis and tilted, in front of a rolled autocollimator."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.typed_content import Number, Positive
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause, Stations
from arctrue.table.declaration import MICROMETRE_M, Declaration, Given, Occasion, Random, Recipe
from arctrue.table.draws import angle
from arctrue.table.instruments.polygon import (
    FACE_WIDTH_M,
    FLATNESS_M,
    MOUNTING_OFFSET_M,
    hollow_slope,
)

AUTOCOLLIMATOR_ROLL_RAD = float(np.deg2rad(1.0))


@dataclass(frozen=True, slots=True)
class PolygonMounting(Cause):
    """The wrong mounting of the polygon gives the reference an error of order 1.

    An autocollimator measures the direction of a face, not its place: if the polygon is
    ``offset_m`` off the axis, the beam only moves sideways over the face. If the face is hollow by
    ``flatness_m`` over ``width_m``, its slope at the beam differs by 8·offset·flatness/width²
    (equation (14) of the paper: 0.0005″ for 1 µm, 0.03 µm and 10 mm).

    The polygon's axis leans by ``tilt_rad``, so that each face tilts up and down once a turn. An
    autocollimator that is rolled by ``roll_rad`` about its line of sight reads tilt·sin(roll) of
    this tilt as a turn of the table.
    """

    offset_m: float
    flatness_m: float
    width_m: float
    tilt_rad: float
    roll_rad: float
    phase_rad: float
    """Phase of the error: at angle + phase = 0 the polygon's centre is farthest to the side and the
    observed face is upright."""

    def instrument_error_rad(
        self, stations: Stations, deviation_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the error of the autocollimator's reading, shape ``(n,)``."""
        own_angle = stations.conditions.angle_rad - stations.turned_rad + self.phase_rad
        sideways_m = self.offset_m * np.cos(own_angle)
        slope = hollow_slope(self.flatness_m, sideways_m, self.width_m)
        nod = -self.tilt_rad * np.sin(own_angle)
        across = deviation_rad + slope
        return np.asarray(
            across * np.cos(self.roll_rad) + nod * np.sin(self.roll_rad) - deviation_rad
        )


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    um: Number
    flatness_um: Number
    face_mm: Positive
    tilt_arcsec: Number
    roll_deg: Number
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> PolygonMounting:
        """Return the cause that these values describe."""
        return PolygonMounting(
            self.um * MICROMETRE_M,
            self.flatness_um * MICROMETRE_M,
            self.face_mm * 1e-3,
            self.tilt_arcsec * RAD_PER_ARCSEC,
            float(np.deg2rad(self.roll_deg)),
            math.radians(self.phase_deg),
        )


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    tilt = size * RAD_PER_ARCSEC / np.sin(AUTOCOLLIMATOR_ROLL_RAD)
    return [
        PolygonMounting(
            MOUNTING_OFFSET_M,
            FLATNESS_M,
            FACE_WIDTH_M,
            float(tilt),
            AUTOCOLLIMATOR_ROLL_RAD,
            angle(random),
        )
    ]


DECLARATION = Declaration(
    PolygonMounting,
    values=Values,
    recipes=(
        Recipe(
            name="polygon_eccentricity",
            unit="arcsec",
            low=0.1,
            high=1.0,
            draw=draw,
            rank=15,
            coefficients=2,
        ),
    ),
)
