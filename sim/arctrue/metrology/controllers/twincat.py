"""Writes the leadscrew error compensation of the TwinCAT CNC (TF5200), one table for each
direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.metrology.controllers.table_format import turn_deg
from arctrue.metrology.controllers.table_of_command import TableOfCommand, wanted_deg
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]

UNITS_PER_DEG = 10_000
"""Number of file units in a degree: the file states angles of rotary axes in whole units of 0.0001°
(0.36″)."""


class TwinCat(TableOfCommand):
    """Compensation value list of a modulo axis: actual minus nominal position, for upward and
    downward motion.

    The controller subtracts the value from the command, linearly interpolated between rows; the row
    at 360° equals the row at 0°. The rounding to 0.0001° causes most of the remaining error.
    """

    name = "twincat"
    file_name = "achskw1.lis"
    points = 360
    most_points = 1500
    """Largest number of entries with the default value of P-COMP-00059."""
    knows_direction = True

    def text(self, correction: Correction, points: int, title: str) -> str:
        interval = 360 * UNITS_PER_DEG / points
        if not interval.is_integer():
            raise ValueError(
                f"--points: twincat needs a step that is a multiple of 0.0001°; with {points} "
                "steps per turn it is not. Choose a divisor of 3600000, such as 360 or 720"
            )
        nominal = turn_deg(points)[:-1]
        up, down = (
            np.rint(-UNITS_PER_DEG * wanted_deg(correction, nominal, way)).astype(int)
            for way in (1, -1)
        )
        lines = [
            f"# {title}",
            "kopf.achs_nr 1",
            f"kw.ssfk.interval {int(interval)}",
            "kw.ssfk.kw_startpos 0",
            f"kw.ssfk.kw_nr_max {points}",
            "kw.ssfk.unit 1",
            "kw.ssfk.bilateral 1",
            "kw.ssfk.modulo 1",
            *(f"kw.ssfk.table[{i}].pos {value}" for i, value in enumerate(up)),
            *(f"kw.ssfk.table[{i}].neg {value}" for i, value in enumerate(down)),
        ]
        return "\n".join(lines) + "\n"

    def added_deg(self, text: str, command_deg: Float, direction: int) -> Float:
        side = ".pos " if direction > 0 else ".neg "
        rows = [int(line.split()[1]) for line in text.splitlines() if side in line]
        return np.asarray(
            -np.interp(command_deg, turn_deg(len(rows)), [*rows, rows[0]]) / UNITS_PER_DEG
        )
