"""Tables by which other controllers correct a rotary axis, and how they interpolate between rows.

Each format is written from the controller's public sources, which docs/reports.md names, and is
read back by a model of the controller's own interpolation.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_TURN, RAD_PER_ARCSEC
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]

ROUNDS = 20
"""g(θ + e) = e settles by a factor of g′, below 0.01, each round."""
GRID = 36_000
"""Angles at which a table is judged: 36″ apart, between the rows of every table."""


@dataclass(frozen=True)
class Left:
    """What the controller leaves of the model's correction, arcseconds."""

    largest_arcsec: float
    rms_arcsec: float


class TableFormat(ABC):
    """A kind of table: its text, and the angle that a controller makes of it."""

    name: ClassVar[str]
    file_name: ClassVar[str]
    """Of the file, where no other is asked for."""
    points: ClassVar[int]
    """Rows over a turn, where no other number is asked for."""
    least_points: ClassVar[int] = 3
    most_points: ClassVar[int] = 100_000
    knows_direction: ClassVar[bool]
    """Does the table tell an approach from below from one from above?"""

    @abstractmethod
    def text(self, correction: Correction, points: int, title: str) -> str:
        """The file's content, for ``points`` rows a turn; ``title`` is a comment where allowed."""

    @abstractmethod
    def angle_error_arcsec(
        self, text: str, correction: Correction, angle_rad: Float, direction: int
    ) -> Float:
        """Angle less true angle that is left with the table, by ``angle_rad`` in [0, 2π).

        The table is taken from ``text``; the axis has exactly the error of ``correction``.
        """

    def left(self, text: str, correction: Correction) -> Left:
        """The error that is left on a fine grid, from below and from above."""
        angle = np.radians(_turn_deg(GRID)[:-1])
        error = np.concatenate(
            [self.angle_error_arcsec(text, correction, angle, way) for way in (1, -1)]
        )
        return Left(float(np.abs(error).max()), float(np.sqrt(np.mean(error**2))))


class _OfReading(TableFormat):
    """A table of what is taken off the reading, by the reading."""

    def angle_error_arcsec(
        self, text: str, correction: Correction, angle_rad: Float, direction: int
    ) -> Float:
        taken = self.taken_off_arcsec(text, np.degrees(angle_rad), direction)
        return correction.error_arcsec(angle_rad, direction) - taken

    @abstractmethod
    def taken_off_arcsec(self, text: str, reading_deg: Float, direction: int) -> Float:
        """What the controller takes off readings in [0°, 360°)."""


class Bidirectional(_OfReading):
    """CSV: reading, and what to take off it from below and from above; linear in between."""

    name = "csv"
    file_name = "correction.csv"
    points = 360
    knows_direction = True
    header = "reading_deg,forward_arcsec,reverse_arcsec"

    def text(self, correction: Correction, points: int, title: str) -> str:
        reading = _turn_deg(points)
        up, down = (correction.error_arcsec(np.radians(reading), way) for way in (1, -1))
        rows = zip(reading, up, down, strict=True)
        return "\n".join([self.header, *(f"{r:.9f},{u:.6f},{d:.6f}" for r, u, d in rows)]) + "\n"

    def taken_off_arcsec(self, text: str, reading_deg: Float, direction: int) -> Float:
        reading, up, down = _columns(text.split("\n", 1)[1].replace(",", " "))
        return np.asarray(np.interp(reading_deg, reading, up if direction > 0 else down))


class LinuxCnc(TableFormat):
    """COMP_FILE of type 0: commanded position, actual position moving up, the same moving down.

    The controller commands the servo nominal + (nominal − actual), linear between rows.
    """

    name = "linuxcnc"
    file_name = "joint.comp"
    points = 255
    most_points = 255
    knows_direction = True

    def text(self, correction: Correction, points: int, title: str) -> str:
        nominal = _turn_deg(points)
        up, down = (nominal - self._wanted_deg(correction, nominal, way) for way in (1, -1))
        rows = zip(nominal, up, down, strict=True)
        return "".join(f"{n:.9f} {u:.9f} {d:.9f}\n" for n, u, d in rows)

    @staticmethod
    def _wanted_deg(correction: Correction, nominal_deg: Float, direction: int) -> Float:
        """ε(θ): so much farther the reading has to go for the table to stand at ``nominal_deg``."""
        angle = np.radians(nominal_deg)
        error = np.zeros_like(angle)
        for _ in range(ROUNDS):
            error = correction.error_arcsec(angle + error * RAD_PER_ARCSEC, direction)
        return error / 3600.0

    def angle_error_arcsec(
        self, text: str, correction: Correction, angle_rad: Float, direction: int
    ) -> Float:
        nominal, up, down = _columns(text)
        trim = nominal - (up if direction > 0 else down)
        added = np.interp(np.degrees(angle_rad), nominal, trim) * 3600.0
        reading = angle_rad + added * RAD_PER_ARCSEC
        return np.asarray(added - correction.error_arcsec(reading, direction))


class Ecmc(_OfReading):
    """Encoder correction of EPICS ecmc: position and what is subtracted, linear between rows."""

    name = "ecmc"
    file_name = "correction.lut"
    points = 720
    knows_direction = False

    def text(self, correction: Correction, points: int, title: str) -> str:
        reading = _turn_deg(points)
        value = correction.by_reading(np.radians(reading)) / 3600.0
        head = [f"# {title}", "# encoder position deg, subtracted deg; range: 360", "PREC=12"]
        rows = (f"{r:.9f} {v:.12f}" for r, v in zip(reading, value, strict=True))
        return "\n".join([*head, *rows]) + "\n"

    def taken_off_arcsec(self, text: str, reading_deg: Float, direction: int) -> Float:
        lines = (line for line in text.splitlines() if line and line[0] not in "#P")
        reading, value = _columns("\n".join(lines))
        return np.asarray(np.interp(np.fmod(reading_deg, 360.0), reading, value) * 3600.0)


class _Moteus(_OfReading):
    """Compensation table of a moteus position source: fractions of a turn that are added."""

    knows_direction = False
    key = "motor_position.sources.0.compensation_"

    def taken_off_arcsec(self, text: str, reading_deg: Float, direction: int) -> Float:
        """The firmware's arithmetic: entry i holds at i/size of a turn; the last meets the first.

        It counts in single precision; here the table's own rounding is the whole of the loss.
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
        reading = np.radians(_turn_deg(self.points)[:-1])
        return np.asarray(-correction.by_reading(reading) / ARCSEC_PER_TURN)


class Moteus32(_Moteus):
    """32 numbers: firmware with a configuration version up to 0x0108."""

    name = "moteus"
    file_name = "moteus.cfg"
    points = least_points = most_points = 32

    def text(self, correction: Correction, points: int, title: str) -> str:
        return "".join(
            f"conf set {self.key}table.{i} {value:.9e}\n"
            for i, value in enumerate(self._turns(correction))
        )


class Moteus256(_Moteus):
    """256 whole numbers of ±127 and their scale: configuration version 0x0109 and later."""

    name = "moteus-256"
    file_name = "moteus.cfg"
    points = least_points = most_points = 256

    def text(self, correction: Correction, points: int, title: str) -> str:
        turns = self._turns(correction)
        scale = float(np.abs(turns).max())
        whole = np.rint(127.0 * turns / scale).astype(int) if scale else np.zeros(256, dtype=int)
        lines = [f"conf set {self.key}table.{i} {value}\n" for i, value in enumerate(whole)]
        return "".join([*lines, f"conf set {self.key}scale {scale:.9e}\n"])


FORMATS: Mapping[str, TableFormat] = {
    one.name: one for one in (Bidirectional(), LinuxCnc(), Ecmc(), Moteus32(), Moteus256())
}


def _turn_deg(points: int) -> Float:
    """0° to 360°, both included: ``points`` equal steps."""
    return np.asarray(np.arange(points + 1) * (360.0 / points), dtype=np.float64)


def _columns(text: str) -> Float:
    """Columns of numbers, (columns, rows)."""
    return np.array([[float(cell) for cell in line.split()] for line in text.splitlines()]).T
