"""Models a table with which a controller changes the command of an axis, not its reading."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_DEG, RAD_PER_ARCSEC
from arctrue.metrology.controllers.table_format import TableFormat
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]

ROUNDS = 20
"""Number of iterations of e ← g(θ + e); each iteration multiplies the remaining difference by g′,
which is below 0.01."""


class TableOfCommand(TableFormat):
    """A table of values that the controller adds to the command; the servo moves the reading to the
    sum."""

    def angle_error_arcsec(
        self, text: str, correction: Correction, angle_rad: Float, direction: int
    ) -> Float:
        added = self.added_deg(text, np.degrees(angle_rad), direction) * ARCSEC_PER_DEG
        reading = angle_rad + added * RAD_PER_ARCSEC
        return np.asarray(added - correction.error_arcsec(reading, direction))

    @abstractmethod
    def added_deg(self, text: str, command_deg: Float, direction: int) -> Float:
        """Return the degrees that the controller adds to commands in [0°, 360°)."""


def wanted_deg(correction: Correction, nominal_deg: Float, direction: int) -> Float:
    """Return ε(θ): the excess of the reading over ``nominal_deg`` when the table's true angle is
    ``nominal_deg``."""
    angle = np.radians(nominal_deg)
    error = np.zeros_like(angle)
    for _ in range(ROUNDS):
        error = correction.error_arcsec(angle + error * RAD_PER_ARCSEC, direction)
    return error / ARCSEC_PER_DEG
