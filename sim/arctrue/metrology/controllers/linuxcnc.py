"""Writes the compensation file of LinuxCNC."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.metrology.controllers.table_format import columns, turn_deg
from arctrue.metrology.controllers.table_of_command import TableOfCommand, wanted_deg
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]


class LinuxCnc(TableOfCommand):
    """Table for COMP_FILE of type 0: commanded position, actual position moving up, actual position
    moving down.

    The controller commands the servo to the position nominal + (nominal − actual), interpolated
    linearly between rows.
    """

    name = "linuxcnc"
    file_name = "joint.comp"
    points = 255
    most_points = 255
    knows_direction = True

    def text(self, correction: Correction, points: int, title: str) -> str:
        nominal = turn_deg(points)
        up, down = (nominal - wanted_deg(correction, nominal, way) for way in (1, -1))
        rows = zip(nominal, up, down, strict=True)
        return "".join(f"{n:.9f} {u:.9f} {d:.9f}\n" for n, u, d in rows)

    def added_deg(self, text: str, command_deg: Float, direction: int) -> Float:
        nominal, up, down = columns(text)
        trim = nominal - (up if direction > 0 else down)
        return np.asarray(np.interp(command_deg, nominal, trim))
