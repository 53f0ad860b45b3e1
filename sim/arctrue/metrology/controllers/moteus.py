"""Writes the compensation tables of a moteus motor controller."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.metrology.controllers.table_format import TableOfReading, turn_deg
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]


class _Moteus(TableOfReading):
    """Compensation table of a moteus position source.

    The entries are fractions of a turn that the controller adds to the position.
    """

    knows_direction = False
    key = "motor_position.sources.0.compensation_"

    def taken_off_arcsec(self, text: str, reading_deg: Float, direction: int) -> Float:
        """Interpolate like the firmware: entry i is the value at i/size of a turn, and the table is
        periodic.

        The firmware calculates in single precision; this model includes the rounding of the table
        but not of the calculation.
        """
        entries: dict[int, float] = {}
        scale = 1.0
        for line in text.splitlines():
            _, _, key, value = line.split()
            kind, _, index = key.removeprefix(self.key).partition(".")
            if kind == "scale":
                scale = float(value) / 127.0
            else:
                entries[int(index)] = float(value)
        table = np.array([entries[i] for i in range(len(entries))]) * scale
        place = np.mod(reading_deg / 360.0, 1.0) * table.size
        left = np.minimum(place.astype(np.int64), table.size - 1)
        fraction = place - left
        added = table[left] * (1.0 - fraction) + table[(left + 1) % table.size] * fraction
        return np.asarray(-added * ARCSEC_PER_TURN)

    def _turns(self, correction: Correction) -> Float:
        reading = np.radians(turn_deg(self.points)[:-1])
        return np.asarray(-correction.by_reading(reading) / ARCSEC_PER_TURN)


class Moteus32(_Moteus):
    """Table of 32 floating-point numbers, for firmware with a configuration version up to
    0x0108."""

    name = "moteus"
    file_name = "moteus.cfg"
    points = least_points = most_points = 32

    def text(self, correction: Correction, points: int, title: str) -> str:
        return "".join(
            f"conf set {self.key}table.{i} {value:.9e}\n"
            for i, value in enumerate(self._turns(correction))
        )


class Moteus256(_Moteus):
    """Table of 256 whole numbers within ±127 and their common scale, for configuration version
    0x0109 and later."""

    name = "moteus-256"
    file_name = "moteus.cfg"
    points = least_points = most_points = 256

    def text(self, correction: Correction, points: int, title: str) -> str:
        turns = self._turns(correction)
        scale = float(np.abs(turns).max())
        whole = np.rint(127.0 * turns / scale).astype(int) if scale else np.zeros(256, dtype=int)
        lines = [f"conf set {self.key}table.{i} {value}\n" for i, value in enumerate(whole)]
        return "".join([*lines, f"conf set {self.key}scale {scale:.9e}\n"])
