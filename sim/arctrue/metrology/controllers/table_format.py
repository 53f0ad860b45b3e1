"""Defines the interface of the controllers' tables: the text of the file, and the error that
remains with the table."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from arctrue.base.figures import figure
from arctrue.metrology.correction import Correction

Float = NDArray[np.float64]

GRID = 36_000
"""Number of angles at which a table is tested. They are 36″ apart, so that they also lie between
the rows of a table with fewer rows."""


@dataclass(frozen=True)
class Left:
    """The error that remains after the controller's correction.

    Parameters
    ----------
    largest_arcsec : float
        Largest absolute error, arcseconds.
    rms_arcsec : float
        Root mean square of the error, arcseconds.
    """

    largest_arcsec: float
    rms_arcsec: float


class TableFormat(ABC):
    """Base class of the formats, which write a file and model the controller that reads it."""

    name: ClassVar[str]
    file_name: ClassVar[str]
    """Default name of the controller's file."""
    points: ClassVar[int]
    """Default number of rows per turn."""
    least_points: ClassVar[int] = 3
    most_points: ClassVar[int] = 100_000
    knows_direction: ClassVar[bool]
    """Whether the table has separate values for an approach from below and from above."""

    def for_axis(self, teeth: float | None, steps_per_second: float | None) -> TableFormat:
        """Return the table format for one axis; most formats do not depend on the axis.

        Parameters
        ----------
        teeth : float or None
            Number of teeth of the worm wheel; None if the set does not state it.
        steps_per_second : float or None
            Motor steps per sidereal second; None if the user does not state them.

        Returns
        -------
        TableFormat
            The format, with those values that it needs.

        Raises
        ------
        ValueError
            If a stated value does not fit the format, or a value that it needs is missing.
        """
        if steps_per_second is not None:
            raise ValueError(f"--steps-per-second: {self.name} does not use this value")
        return self

    def check_points(self, points: int | None) -> None:
        """Check a number of rows per turn.

        Parameters
        ----------
        points : int or None
            Number of rows per turn; None stands for the default.

        Raises
        ------
        ValueError
            If the controller does not accept this number.
        """
        least, most = self.least_points, self.most_points
        if points is not None and not least <= points <= most:
            takes = str(most) if least == most else f"{least} to {most}"
            raise ValueError(f"--points: {self.name} takes {takes} steps a turn, found {points}")

    def not_corrected(self, correction: Correction) -> list[str]:
        """List the parts of the model that the table does not correct.

        Parameters
        ----------
        correction : Correction
            The part that the table can hold, from :meth:`part_of`.

        Returns
        -------
        list of str
            One sentence for each part.
        """
        left_out = list(correction.left_out)
        if correction.reversal_arcsec and not self.knows_direction:
            left_out.append(
                f"reversal error {figure(correction.reversal_arcsec, 3, signed=True)}″: the table "
                "has no values by direction"
            )
        return left_out

    def part_of(self, correction: Correction) -> Correction:
        """Return the part of a correction that the table can represent.

        Parameters
        ----------
        correction : Correction
            The whole correction of the model.

        Returns
        -------
        Correction
            The part that the table can hold; its ``left_out`` lists the remainder.
        """
        return correction

    @abstractmethod
    def text(self, correction: Correction, points: int, title: str) -> str:
        """Return the content of the file.

        Parameters
        ----------
        correction : Correction
            Correction that the table contains.
        points : int
            Number of rows per turn.
        title : str
            Comment for formats that have comments.

        Returns
        -------
        str
            Content of the file.
        """

    @abstractmethod
    def angle_error_arcsec(
        self, text: str, correction: Correction, angle_rad: Float, direction: int
    ) -> Float:
        """Compute the error that remains when the controller uses the table.

        Parameters
        ----------
        text : str
            Content of the file.
        correction : Correction
            Error of the axis.
        angle_rad : ndarray, shape (n,)
            Angles in [0, 2π), radians.
        direction : int
            Direction of approach: 1 from below, −1 from above.

        Returns
        -------
        ndarray, shape (n,)
            Angle minus true angle, arcseconds.
        """

    def left(self, text: str, correction: Correction) -> Left:
        """Return the error that remains on a fine grid of angles, approached from both sides.

        Parameters
        ----------
        text : str
            Content of the file.
        correction : Correction
            Error of the axis.

        Returns
        -------
        Left
            Largest error and root mean square.
        """
        angle = np.radians(turn_deg(GRID)[:-1])
        error = np.concatenate(
            [self.angle_error_arcsec(text, correction, angle, way) for way in (1, -1)]
        )
        return Left(float(np.abs(error).max()), float(np.sqrt(np.mean(error**2))))


class TableOfReading(TableFormat):
    """A table of values that the controller subtracts from the reading, as a function of the
    reading."""

    def angle_error_arcsec(
        self, text: str, correction: Correction, angle_rad: Float, direction: int
    ) -> Float:
        taken = self.taken_off_arcsec(text, np.degrees(angle_rad), direction)
        return correction.error_arcsec(angle_rad, direction) - taken

    @abstractmethod
    def taken_off_arcsec(self, text: str, reading_deg: Float, direction: int) -> Float:
        """Return the value that the controller subtracts from each reading in [0°, 360°)."""


def turn_deg(points: int) -> Float:
    """Return the angles 0° to 360°, both included, in ``points`` equal steps."""
    return np.asarray(np.arange(points + 1) * (360.0 / points), dtype=np.float64)


def columns(text: str) -> Float:
    """Read lines of numbers and return their columns, (columns, rows)."""
    return np.array([[float(cell) for cell in line.split()] for line in text.splitlines()]).T
