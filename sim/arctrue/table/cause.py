"""Defines the quantities on which a physical cause can act: axis, disc, heads, lines, counters,
noise."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.conditions import Conditions
from arctrue.table.motion import Motion
from arctrue.table.noise import Noise
from arctrue.table.state import TableState
from arctrue.table.temperature import TemperatureCourse

Angles = NDArray[np.float64]
Points = NDArray[np.complex128]
"""Points or displacements in the plane, x + jy in metres, shape ``(n,)``."""


@dataclass(frozen=True, slots=True)
class Stations:
    """Stations at which a reference instrument is read, in arrays ``(n,)``."""

    conditions: Conditions
    face: NDArray[np.int64]
    """Number of the polygon's face that the autocollimator observes."""
    turned_rad: NDArray[np.float64] | float = 0.0
    """Angle of the instrument relative to the table, which was fixed when the instrument was
    mounted."""


class Cause:
    """Base class of all causes; a method that a cause does not override has no effect.

    The table adds the results of its causes, each in the frame that the method states. A cause
    describes a displacement, never a reading: the table computes the reading by geometry.
    """

    def axis_shift_m(self, state: TableState) -> Points | complex:
        """Return the displacement of the axis in the stator frame.

        Parameters
        ----------
        state : TableState
            Instants at which the quantity is requested, shape (n,).

        Returns
        -------
        ndarray or complex
            Displacement x + jy, metres, shape (n,), or one for all instants.
        """
        return 0.0

    def disc_shift_m(self, state: TableState) -> Points | complex:
        """Return the displacement of the disc centre in the frame of the turning table.

        Parameters
        ----------
        state : TableState
            Instants at which the quantity is requested, shape (n,).

        Returns
        -------
        ndarray or complex
            Displacement x + jy, metres, shape (n,), or one for all instants.
        """
        return 0.0

    def head_shift_m(self, head: int, state: TableState) -> Points | complex:
        """Return the displacement of a head in the stator frame.

        Parameters
        ----------
        head : int
            Number of the head, from 0.
        state : TableState
            Instants at which the quantity is requested, shape (n,).

        Returns
        -------
        ndarray or complex
            Displacement x + jy, metres, shape (n,), or one for all instants.
        """
        return 0.0

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64] | float:
        """Return the error of the lines at a disc angle, a function with a period of one turn.

        Parameters
        ----------
        disc_angle_rad : ndarray
            Disc angle, not wrapped, radians, shape (n,).
        state : TableState
            Instants at which the quantity is requested, shape (n,).

        Returns
        -------
        ndarray or float
            Error of the lines there, radians, shape (n,).
        """
        return 0.0

    def signal_error_rad(
        self, head: int, disc_reading_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64] | float:
        """Return the error that a head's signal adds to the angle of the lines under the head.

        Parameters
        ----------
        head : int
            Number of the head, from 0.
        disc_reading_rad : ndarray
            Angle that the lines under the head state, radians, shape (n,).
        state : TableState
            Instants at which the quantity is requested, shape (n,).

        Returns
        -------
        ndarray or float
            Error, radians, shape (n,).
        """
        return 0.0

    def disc_turn_rad(self, conditions: Conditions) -> Angles | float:
        """Return the angle of the disc relative to the table top, on which the reference stands.

        Parameters
        ----------
        conditions : Conditions
            State of the table and its surroundings at n instants, shape (n,).

        Returns
        -------
        ndarray or float
            Angle, radians, shape (n,).
        """
        return 0.0

    def sampling_delay_s(self, head: int) -> float:
        """Return the age of a head's reading at the moment when the reading is latched.

        Parameters
        ----------
        head : int
            Number of the head, from 0.

        Returns
        -------
        float
            Seconds.
        """
        return 0.0

    def gained_counts(self, head: int, conditions: Conditions) -> NDArray[np.int64] | int:
        """Return the number of counts that a head's counter has gained up to each instant.

        Parameters
        ----------
        head : int
            Number of the head, from 0.
        conditions : Conditions
            State of the table and its surroundings at n instants, shape (n,).

        Returns
        -------
        ndarray or int
            Counts, negative for lost counts, shape (n,).
        """
        return 0

    def instrument_error_rad(self, stations: Stations, deviation_rad: Angles) -> Angles | float:
        """Return the error of the reference instrument.

        Parameters
        ----------
        stations : Stations
            The stations at which it is read.
        deviation_rad : ndarray
            Reading of a perfect instrument minus the true angle, radians, shape (n,).

        Returns
        -------
        ndarray or float
            Error, radians, shape (n,).
        """
        return 0.0

    def head_noise(self, head: int, conditions: Conditions) -> Noise | None:
        """Return the Gaussian noise of a head's reading.

        Parameters
        ----------
        head : int
            Number of the head, from 0.
        conditions : Conditions
            State of the table and its surroundings at n instants, shape (n,).

        Returns
        -------
        Noise or None
            None: no noise.
        """
        return None

    def instrument_noise(self, stations: Stations) -> Noise | None:
        """Return the Gaussian noise of the reference instrument.

        Parameters
        ----------
        stations : Stations
            The stations at which it is read.

        Returns
        -------
        Noise or None
            None: no noise.
        """
        return None

    def struck_rad(
        self, head: int, conditions: Conditions, random: np.random.Generator
    ) -> Angles | None:
        """Draw the errors of those rows of a head that are wrong.

        Parameters
        ----------
        head : int
            Number of the head, from 0.
        conditions : Conditions
            State of the table and its surroundings at n instants, shape (n,).
        random : numpy.random.Generator
            Source of the random numbers.

        Returns
        -------
        ndarray or None
            Errors, radians, shape (n,), 0 in all other rows; None: no row is wrong.
        """
        return None

    def index_shift_counts(self, random: np.random.Generator) -> int:
        """Draw the shift of the place at which a head detects its index mark in one run.

        Parameters
        ----------
        random : numpy.random.Generator
            Source of the random numbers.

        Returns
        -------
        int
            Counts.
        """
        return 0

    def index_variance_counts2(self) -> float:
        """Return the variance of :meth:`index_shift_counts`.

        Returns
        -------
        float
            Counts squared.
        """
        return 0.0

    def shown_temperature_c(self, course: TemperatureCourse, time_s: Angles) -> Angles | None:
        """Return the temperature that the sensor shows in place of the true temperature.

        Parameters
        ----------
        course : TemperatureCourse
            True temperature over the time of the surroundings.
        time_s : ndarray
            Instants in the time of the surroundings, seconds, shape (n,).

        Returns
        -------
        ndarray or None
            Temperature, °C, shape (n,); None: the true one.
        """
        return None

    def kept_rows(
        self, conditions: Conditions, random: np.random.Generator
    ) -> NDArray[np.bool_] | None:
        """Draw the rows that are recorded.

        Parameters
        ----------
        conditions : Conditions
            State of the table and its surroundings at n instants, shape (n,).
        random : numpy.random.Generator
            Source of the random numbers.

        Returns
        -------
        ndarray or None
            True for each row that is recorded, shape (n,); None: all of them.
        """
        return None

    def driven(self, motion: Motion) -> Motion:
        """Return the motion that the drive makes when a motion is requested.

        Parameters
        ----------
        motion : Motion
            The requested motion.

        Returns
        -------
        Motion
            The motion of the table.
        """
        return motion


GEOMETRY = frozenset(
    {
        "axis_shift_m",
        "disc_shift_m",
        "head_shift_m",
        "graduation_error_rad",
        "signal_error_rad",
    }
)
"""Methods that move points and lines and draw no random numbers."""
READING = GEOMETRY | {"disc_turn_rad", "sampling_delay_s", "gained_counts"}
"""Methods whose quantities :meth:`arctrue.table.rotary_table.RotaryTable.reading_rad` applies."""
SIGNALS = READING - {"gained_counts"}
"""Methods whose quantities act before the counter and therefore displace the edges of a head."""
CAPTURE = READING | {
    "head_noise",
    "struck_rad",
    "index_shift_counts",
    "shown_temperature_c",
    "kept_rows",
    "driven",
}
"""Methods whose quantities a recorded run of the heads includes."""
REFERENCE = SIGNALS | {"instrument_error_rad", "instrument_noise", "head_noise", "struck_rad"}
"""Methods whose quantities a recorded reference run includes."""
RECORD = frozenset(name for name in vars(Cause) if not name.startswith("_"))
"""Names of all methods of a cause."""


def acts_on(cause: Cause | type[Cause]) -> frozenset[str]:
    """Return the methods of :class:`Cause` that the cause overrides, without
    ``index_variance_counts2``."""
    kind = cause if isinstance(cause, type) else type(cause)
    overridden = {name for name in RECORD if getattr(kind, name) is not getattr(Cause, name)}
    return frozenset(overridden - {"index_variance_counts2"})


class UnhonouredCauseError(ValueError):
    """Is raised if a cause acts on a quantity that the caller does not simulate."""


def refuse_unhonoured(causes: Iterable[Cause], honoured: frozenset[str], consumer: str) -> None:
    """Raise UnhonouredCauseError if ``consumer`` would silently ignore a method that a cause
    overrides."""
    for cause in causes:
        left = sorted(acts_on(cause) - honoured)
        if left:
            raise UnhonouredCauseError(
                f"{consumer} cannot honour the cause {type(cause).__name__}: "
                f"it acts on {', '.join(left)}, which is not simulated there"
            )
