"""Quantities on which a physical cause can act: axis, disc, heads, lines, counters, noise."""

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
    """Stations at which a reference instrument is read; arrays ``(n,)``."""

    conditions: Conditions
    face: NDArray[np.int64]
    """Number of the polygon's face that the autocollimator sees."""
    turned_rad: NDArray[np.float64] | float = 0.0
    """Angle by which the instrument was turned on the table when it was mounted."""


class Cause:
    """Base of every cause: each method returns one quantity; the default is no effect.

    The table adds the results of its causes, each in the frame that the method states. A cause
    describes a displacement, never a reading: the reading follows from the geometry.
    """

    def axis_shift_m(self, state: TableState) -> Points | complex:
        """Displacement of the axis in the stator frame."""
        return 0.0

    def disc_shift_m(self, state: TableState) -> Points | complex:
        """Displacement of the disc centre from the axis in the frame of the turning table."""
        return 0.0

    def head_shift_m(self, head: int, state: TableState) -> Points | complex:
        """Displacement of head 0, 1, … in the stator frame."""
        return 0.0

    def graduation_error_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64] | float:
        """Error of the lines at a disc angle; period one turn."""
        return 0.0

    def signal_error_rad(
        self, head: int, disc_reading_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64] | float:
        """Error that the signal of head 0, 1, … adds to the lines that it sees."""
        return 0.0

    def disc_turn_rad(self, conditions: Conditions) -> Angles | float:
        """Angle by which the disc is turned against the table top, which carries the reference."""
        return 0.0

    def sampling_delay_s(self, head: int) -> float:
        """Age of the reading of head 0, 1, … when it is latched."""
        return 0.0

    def gained_counts(self, head: int, conditions: Conditions) -> NDArray[np.int64] | int:
        """Counts gained by the counter of head 0, 1, … (lost: negative) up to each instant."""
        return 0

    def instrument_error_rad(self, stations: Stations, deviation_rad: Angles) -> Angles | float:
        """Error of the instrument on ``deviation_rad``, the true reading minus the true angle."""
        return 0.0

    def head_noise(self, head: int, conditions: Conditions) -> Noise | None:
        """Gaussian noise of the reading of head 0, 1, …."""
        return None

    def instrument_noise(self, stations: Stations) -> Noise | None:
        """Gaussian noise of the reference instrument."""
        return None

    def struck_rad(
        self, head: int, conditions: Conditions, random: np.random.Generator
    ) -> Angles | None:
        """Errors of single rows of head 0, 1, …; 0 in all other rows."""
        return None

    def index_shift_counts(self, random: np.random.Generator) -> int:
        """Offset in counts with which a head detects its index in one run."""
        return 0

    def index_variance_counts2(self) -> float:
        """Variance of :meth:`index_shift_counts`."""
        return 0.0

    def shown_temperature_c(self, course: TemperatureCourse, time_s: Angles) -> Angles | None:
        """Temperature that the sensor shows instead of the true temperature."""
        return None

    def kept_rows(
        self, conditions: Conditions, random: np.random.Generator
    ) -> NDArray[np.bool_] | None:
        """True for each row that is recorded."""
        return None

    def driven(self, motion: Motion) -> Motion:
        """Return the motion that the drive makes of the requested motion."""
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
"""Methods that move points and lines, and draw no random numbers."""
READING = GEOMETRY | {"disc_turn_rad", "sampling_delay_s", "gained_counts"}
"""Methods that :meth:`arctrue.table.rotary_table.RotaryTable.reading_rad` applies."""
SIGNALS = READING - {"gained_counts"}
"""Methods that act before the counter: the edges of a head."""
CAPTURE = READING | {
    "head_noise",
    "struck_rad",
    "index_shift_counts",
    "shown_temperature_c",
    "kept_rows",
    "driven",
}
"""Methods that recorded runs of the heads apply."""
REFERENCE = SIGNALS | {"instrument_error_rad", "instrument_noise", "head_noise", "struck_rad"}
"""Methods that a recorded reference run applies."""
RECORD = frozenset(name for name in vars(Cause) if not name.startswith("_"))
"""All methods of a cause."""


def acts_on(cause: Cause | type[Cause]) -> frozenset[str]:
    """Return the methods of :class:`Cause` that the cause overrides."""
    kind = cause if isinstance(cause, type) else type(cause)
    overridden = {name for name in RECORD if getattr(kind, name) is not getattr(Cause, name)}
    return frozenset(overridden - {"index_variance_counts2"})


class UnhonouredCauseError(ValueError):
    """A cause acts on a quantity that its consumer does not simulate."""


def refuse_unhonoured(causes: Iterable[Cause], honoured: frozenset[str], consumer: str) -> None:
    """Raise UnhonouredCauseError if ``consumer`` would silently ignore a part of a cause."""
    for cause in causes:
        left = sorted(acts_on(cause) - honoured)
        if left:
            raise UnhonouredCauseError(
                f"{consumer} cannot honour the cause {type(cause).__name__}: "
                f"it acts on {', '.join(left)}, which is not simulated there"
            )
