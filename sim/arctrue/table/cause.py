"""What a physical cause can act on: axis, disc, heads, lines, counters, noise, instrument."""

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
    """Where a reference instrument is read; arrays ``(n,)``."""

    conditions: Conditions
    face: NDArray[np.int64]
    """Which face of the polygon the autocollimator sees."""
    turned_rad: NDArray[np.float64] | float = 0.0
    """By how much the instrument was turned on the table when it was put on."""


class Cause:
    """Base of every cause: each method returns what happens there; the default is nothing.

    The table adds what its causes return, each in the frame named by the method. A cause
    says what happens, never what a reading becomes: that follows from the geometry.
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
        """What the lines at a disc angle say too much; period one turn."""
        return 0.0

    def signal_error_rad(
        self, head: int, disc_reading_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64] | float:
        """What the signal of head 0, 1, … adds to the lines that it sees."""
        return 0.0

    def disc_turn_rad(self, conditions: Conditions) -> Angles | float:
        """How far the disc is turned against the top of the table, on which the reference sits."""
        return 0.0

    def sampling_delay_s(self, head: int) -> float:
        """How old the reading of head 0, 1, … is when it is latched."""
        return 0.0

    def gained_counts(self, head: int, conditions: Conditions) -> NDArray[np.int64] | int:
        """What the counter of head 0, 1, … has gained (or lost, negative) by then."""
        return 0

    def instrument_error_rad(self, stations: Stations, deviation_rad: Angles) -> Angles | float:
        """What the instrument adds to ``deviation_rad``, the true reading less true angle."""
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
        """What single rows of head 0, 1, … are off; 0 in the rows that are not struck."""
        return None

    def index_shift_counts(self, random: np.random.Generator) -> int:
        """How many counts off one head takes its index in one run."""
        return 0

    def index_variance_counts2(self) -> float:
        """Variance of :meth:`index_shift_counts`."""
        return 0.0

    def shown_temperature_c(self, course: TemperatureCourse, time_s: Angles) -> Angles | None:
        """What the temperature sensor shows in place of the true temperature."""
        return None

    def kept_rows(
        self, conditions: Conditions, random: np.random.Generator
    ) -> NDArray[np.bool_] | None:
        """Which rows are recorded."""
        return None

    def driven(self, motion: Motion) -> Motion:
        """The motion that the drive makes of the one that it was asked for."""
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
"""What moves points and lines, and draws no random numbers."""
READING = GEOMETRY | {"disc_turn_rad", "sampling_delay_s", "gained_counts"}
"""What :meth:`arctrue.table.rotary_table.RotaryTable.reading_rad` honours."""
SIGNALS = READING - {"gained_counts"}
"""What stands before the counter: the edges of a head."""
CAPTURE = READING | {
    "head_noise",
    "struck_rad",
    "index_shift_counts",
    "shown_temperature_c",
    "kept_rows",
    "driven",
}
"""What the recorded runs of the heads honour."""
REFERENCE = SIGNALS | {"instrument_error_rad", "instrument_noise", "head_noise", "struck_rad"}
"""What a recorded reference run honours."""
RECORD = frozenset(name for name in vars(Cause) if not name.startswith("_"))
"""Everything that a cause can act on."""


def acts_on(cause: Cause | type[Cause]) -> frozenset[str]:
    """Return the methods of :class:`Cause` that the cause overrides."""
    kind = cause if isinstance(cause, type) else type(cause)
    overridden = {name for name in RECORD if getattr(kind, name) is not getattr(Cause, name)}
    return frozenset(overridden - {"index_variance_counts2"})


class UnhonouredCauseError(ValueError):
    """A cause acts on something that its consumer does not have."""


def refuse_unhonoured(causes: Iterable[Cause], honoured: frozenset[str], consumer: str) -> None:
    """Raise UnhonouredCauseError for a cause of which ``consumer`` would drop a part unsaid."""
    for cause in causes:
        left = sorted(acts_on(cause) - honoured)
        if left:
            raise UnhonouredCauseError(
                f"{consumer} cannot honour the cause {type(cause).__name__}: "
                f"it acts on {', '.join(left)}, which is not simulated there"
            )
