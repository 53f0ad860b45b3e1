"""Writes the encoder look-up table of EPICS ecmc."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_DEG
from arctrue.metrology.controllers.table_format import TableOfReading, columns, turn_deg
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]


class Ecmc(TableOfReading):
    """Look-up table of EPICS ecmc: encoder position and value that ecmc subtracts, interpolated
    linearly between rows."""

    name = "ecmc"
    file_name = "correction.lut"
    points = 720
    knows_direction = False

    def text(self, correction: Correction, points: int, title: str) -> str:
        reading = turn_deg(points)
        value = correction.by_reading(np.radians(reading)) / ARCSEC_PER_DEG
        head = [f"# {title}", "# encoder position deg, subtracted deg; range: 360", "PREC=12"]
        rows = (f"{r:.9f} {v:.12f}" for r, v in zip(reading, value, strict=True))
        return "\n".join([*head, *rows]) + "\n"

    def taken_off_arcsec(self, text: str, reading_deg: Float, direction: int) -> Float:
        lines = (line for line in text.splitlines() if line and line[0] not in "#P")
        reading, value = columns("\n".join(lines))
        return np.asarray(np.interp(np.fmod(reading_deg, 360.0), reading, value) * ARCSEC_PER_DEG)
