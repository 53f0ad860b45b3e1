"""Defines the conditions of a reading: the state of the table and further quantities that some
causes need."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.table.state import TableState

USUAL_TEMPERATURE_C = 20.0
"""Temperature at which the table was adjusted; all thermal effects are zero at this temperature."""


@dataclass(frozen=True, slots=True)
class Conditions(TableState):
    """The state of a table together with the conditions at each instant; every array has the shape
    ``(n,)``."""

    temperature_c: NDArray[np.float64]
    direction: NDArray[np.float64]
    """Direction in which the table approached the angle, +1 or −1; 0 if unknown."""
    run: NDArray[np.int64]
    since_run_start_s: NDArray[np.float64]
    travelled_rad: NDArray[np.float64] | None = None
    """Sum of the travel in both directions since the table was set up; None if unknown."""
    since_reversal_rad: NDArray[np.float64] | None = None
    """Travel since the last reversal; None if unknown."""

    def turned(self, angle_rad: NDArray[np.float64]) -> Conditions:
        """Return the same conditions at other angles."""
        return replace(self, angle_rad=angle_rad)


def conditions_of(state: TableState) -> Conditions:
    """Return the state as :class:`Conditions`.

    A state without conditions gets the usual temperature, a time long after the start, and its
    direction of motion as the direction of approach (0 at rest).
    """
    if isinstance(state, Conditions):
        return state
    like = state.angle_rad
    return Conditions(
        state.time_s,
        state.angle_rad,
        state.speed_rad_s,
        np.full_like(like, USUAL_TEMPERATURE_C),
        np.sign(state.speed_rad_s),
        np.zeros(like.shape, dtype=np.int64),
        np.full_like(like, np.inf),
    )


def heating_k(state: TableState) -> NDArray[np.float64]:
    """Return the temperature rise above the temperature at adjustment, K, shape ``(n,)``."""
    return conditions_of(state).temperature_c - USUAL_TEMPERATURE_C


def travelled_turns(state: TableState) -> NDArray[np.float64]:
    """Return the number of turns since the table was set up, shape ``(n,)``. Raises ValueError if
    it is unknown."""
    travelled = conditions_of(state).travelled_rad
    if travelled is None:
        raise ValueError("a cause grows with use, but the travel of the table is not known")
    return travelled / (2 * np.pi)
