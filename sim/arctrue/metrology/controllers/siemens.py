"""Writes the measuring system error compensation of Siemens SINUMERIK 840D sl and 828D."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_DEG
from arctrue.metrology.controllers.table_format import TableOfReading, turn_deg
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]

VALUE = re.compile(r"\$AA_ENC_COMP\[0,(\d+),AX1\]=(\S+)")


class Siemens(TableOfReading):
    """Table $AA_ENC_COMP of encoder 0, machine axis AX1: degrees that the controller adds to the
    actual position."""

    name = "siemens"
    file_name = "AX1_EEC.INI"
    points = 360
    most_points = 4999
    """Largest number of rows: MD38000 permits 5,000 interpolation points, and the row at 360° needs
    one of them."""
    knows_direction = False

    def text(self, correction: Correction, points: int, title: str) -> str:
        reading = turn_deg(points)
        added = -correction.by_reading(np.radians(reading)) / ARCSEC_PER_DEG
        rows = [f"$AA_ENC_COMP[0,{i},AX1]={value:.9f}" for i, value in enumerate(added)]
        lines = [
            "%_N_AX1_EEC_INI",
            f"; {title}",
            "CHANDATA(1)",
            *rows,
            f"$AA_ENC_COMP_STEP[0,AX1]={360.0 / points:.12g}",
            "$AA_ENC_COMP_MIN[0,AX1]=0.0",
            "$AA_ENC_COMP_MAX[0,AX1]=360.0",
            "$AA_ENC_COMP_IS_MODULO[0,AX1]=1",
            "M17",
        ]
        return "\n".join(lines) + "\n"

    def taken_off_arcsec(self, text: str, reading_deg: Float, direction: int) -> Float:
        added = np.array([float(match[2]) for match in VALUE.finditer(text)])
        return np.asarray(-ARCSEC_PER_DEG * np.interp(reading_deg, turn_deg(added.size - 1), added))
