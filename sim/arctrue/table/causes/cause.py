"""What a cause can move beside the parts of the table: sampling, counters, the instrument."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.conditions import Conditions

Angles = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Stations:
    """Where a reference instrument is read; arrays ``(n,)``."""

    conditions: Conditions
    face: NDArray[np.int64]
    """Which face of the polygon the autocollimator sees."""
    turned_rad: NDArray[np.float64] | float = 0.0
    """By how much the instrument was turned on the table when it was put on."""


class Cause(PhysicalEffect):
    """Base of the causes that need the conditions, or act outside of disc, axis and heads.

    Each method returns what happens there; the default is nothing.
    """

    def disc_turn_rad(self, conditions: Conditions) -> Angles | float:
        """How far the disc is turned against the top of the table, on which the reference sits."""
        return 0.0

    def sampling_delay_s(self, head: int) -> float:
        """How old the reading of head 0 or 1 is when it is latched."""
        return 0.0

    def gained_counts(self, head: int, conditions: Conditions) -> NDArray[np.int64] | int:
        """What the counter of head 0 or 1 has gained (or lost, negative) by then."""
        return 0

    def instrument_error_rad(self, stations: Stations, deviation_rad: Angles) -> Angles | float:
        """What the instrument adds to ``deviation_rad``, the true reading less true angle."""
        return 0.0
