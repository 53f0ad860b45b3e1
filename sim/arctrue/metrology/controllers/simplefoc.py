"""Writes the look-up table of SimpleFOC's CalibratedSensor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.metrology.controllers.table_format import TableOfReading, turn_deg
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]


class SimpleFoc(TableOfReading):
    """C array of angles in radians that the library subtracts from the sensor's angle, interpolated
    linearly between entries.

    The library calculates in single precision. The remaining error that the command states does not
    include the library's rounding, 0.1″ near a full turn.
    """

    name = "simplefoc"
    file_name = "calibration_lut.h"
    points = 200
    knows_direction = False

    def text(self, correction: Correction, points: int, title: str) -> str:
        reading = np.radians(turn_deg(points)[:-1])
        rows = correction.by_reading(reading) * RAD_PER_ARCSEC
        values = "".join(f"    {value:.9e}f,\n" for value in rows)
        comment = title.replace("\\", "/")  # a backslash at the end would continue the C comment
        return f"// {comment}\nfloat calibrationLut[{points}] = {{\n{values}}};\n"

    def taken_off_arcsec(self, text: str, reading_deg: Float, direction: int) -> Float:
        body = text.split("{\n", 1)[1]
        rows = [float(line.strip().rstrip("f,")) for line in body.splitlines()[:-1]]
        return np.asarray(
            np.interp(reading_deg, turn_deg(len(rows)), [*rows, rows[0]]) / RAD_PER_ARCSEC
        )
