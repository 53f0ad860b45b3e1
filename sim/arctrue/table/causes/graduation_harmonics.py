"""Models errors of the graduation that vary slowly around the disc."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.typed_content import Number
from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Given, Occasion, Order, Random, Recipe
from arctrue.table.draws import angle
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class GraduationHarmonics(Cause):
    """The graduation error is Σ amplitude·cos(order·disc angle + phase).

    The three tuples have one value for each harmonic. Ovality and tilt of the disc give order 2,
    clamping screws give orders 3 to 8. Raises ValueError if the tuples differ in length.
    """

    orders: tuple[int, ...]
    """Order of each harmonic, 1 or more."""
    amplitudes_rad: tuple[float, ...]
    """Amplitude of each harmonic, radians."""
    phases_rad: tuple[float, ...]
    """Phase of each harmonic, radians."""

    def __post_init__(self) -> None:
        """Raise ValueError for tuples of different lengths and for orders below 1."""
        if not len(self.orders) == len(self.amplitudes_rad) == len(self.phases_rad):
            raise ValueError("graduation harmonics need one amplitude and one phase an order")
        if any(order < 1 for order in self.orders):
            raise ValueError(f"orders of graduation harmonics begin at 1, found {self.orders}")

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """Return the sum of the harmonics at each disc angle.

        Parameters
        ----------
        disc_angle_rad : ndarray
            Disc angle, radians, shape (n,).
        state : TableState
            State of the table; it has no influence.

        Returns
        -------
        ndarray
            Error of the lines, radians, shape (n,).
        """
        error = np.zeros_like(disc_angle_rad)
        for order, amplitude, phase in zip(
            self.orders, self.amplitudes_rad, self.phases_rad, strict=True
        ):
            error += amplitude * np.cos(order * disc_angle_rad + phase)
        return error


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    order: Order
    arcsec: Number
    phase_deg: Number = 0.0

    def physical(self, lines: int) -> GraduationHarmonics:
        """Return the cause that these values describe."""
        size, phase = self.arcsec * RAD_PER_ARCSEC, math.radians(self.phase_deg)
        return GraduationHarmonics((self.order,), (size,), (phase,))


def draw(size: float, random: Random, _: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    order = int(random.integers(21, 240))
    return [GraduationHarmonics((order,), (size * RAD_PER_ARCSEC,), (angle(random),))]


DECLARATION = Declaration(
    GraduationHarmonics,
    values=Values,
    recipes=(
        Recipe(
            name="high_order_graduation",
            unit="arcsec",
            low=0.1,
            high=1.0,
            draw=draw,
            rank=0,
            coefficients=2,
            places=220,
        ),
    ),
)
