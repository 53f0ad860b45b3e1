"""The lines are not where they belong: slow errors around the disc."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class GraduationHarmonics(PhysicalEffect):
    """Graduation error Σ amplitude·cos(order·disc angle + phase).

    The three tuples have one value a harmonic. Ovality and tilt of the disc give order 2,
    clamping screws 3 to 8. Raises ValueError where the tuples differ in length.
    """

    orders: tuple[int, ...]
    amplitudes_rad: tuple[float, ...]
    phases_rad: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse what cannot be built."""
        if not len(self.orders) == len(self.amplitudes_rad) == len(self.phases_rad):
            raise ValueError("graduation harmonics need one amplitude and one phase an order")
        if any(order < 1 for order in self.orders):
            raise ValueError(f"orders of graduation harmonics begin at 1, found {self.orders}")

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """The sum of the harmonics at each disc angle, shape ``(n,)``."""
        error = np.zeros_like(disc_angle_rad)
        for order, amplitude, phase in zip(
            self.orders, self.amplitudes_rad, self.phases_rad, strict=True
        ):
            error += amplitude * np.cos(order * disc_angle_rad + phase)
        return error
