"""Writes a correction table for a program of the user's own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.metrology.controllers.table_format import TableOfReading, columns, turn_deg
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]


class Bidirectional(TableOfReading):
    """CSV table with the reading and two values to subtract, one for an approach from below and one
    from above.

    The program subtracts the value of the present direction from the reading, and interpolates
    linearly between rows.
    """

    name = "csv"
    file_name = "correction.csv"
    points = 360
    knows_direction = True
    header = "reading_deg,forward_arcsec,reverse_arcsec"

    def text(self, correction: Correction, points: int, title: str) -> str:
        reading = turn_deg(points)
        up, down = (correction.error_arcsec(np.radians(reading), way) for way in (1, -1))
        rows = zip(reading, up, down, strict=True)
        return "\n".join([self.header, *(f"{r:.9f},{u:.6f},{d:.6f}" for r, u, d in rows)]) + "\n"

    def taken_off_arcsec(self, text: str, reading_deg: Float, direction: int) -> Float:
        reading, up, down = columns(text.split("\n", 1)[1].replace(",", " "))
        return np.asarray(np.interp(reading_deg, reading, up if direction > 0 else down))
