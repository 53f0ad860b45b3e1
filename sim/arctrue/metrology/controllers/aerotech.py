"""Writes the axis calibration file of Aerotech's controllers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_DEG
from arctrue.metrology.controllers.table_format import turn_deg
from arctrue.metrology.controllers.table_of_command import TableOfCommand, wanted_deg
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]

VALUES_A_LINE = 6
"""Number of values in a line, as in Aerotech's own files; the controller does not need it."""


class Aerotech(TableOfCommand):
    """One-dimensional calibration table of axis 1: arcseconds that the controller adds to the
    command, linear between rows.

    The rows cover 0° to 360°, because outside its rows the controller uses the value of the nearest
    row.
    """

    name = "aerotech"
    file_name = "axis1.cal"
    points = 360
    knows_direction = False

    def text(self, correction: Correction, points: int, title: str) -> str:
        nominal = turn_deg(points)
        wanted = np.mean([wanted_deg(correction, nominal, way) for way in (1, -1)], axis=0)
        values = [f"{value * ARCSEC_PER_DEG:.6f}" for value in wanted]
        lines = [
            f"; {title}",
            f":START 1 SAMPLEDIST={360.0 / points:.12g} POSUNIT=PRIMARY CORUNIT=PRIMARY/3600",
            *(
                " ".join(values[first : first + VALUES_A_LINE])
                for first in range(0, len(values), VALUES_A_LINE)
            ),
            ":END",
        ]
        return "\n".join(lines) + "\n"

    def added_deg(self, text: str, command_deg: Float, direction: int) -> Float:
        words = [word for line in text.splitlines() if line[0] not in ";:" for word in line.split()]
        rows = np.array([float(word) for word in words]) / ARCSEC_PER_DEG
        return np.asarray(np.interp(command_deg, turn_deg(rows.size - 1), rows))
