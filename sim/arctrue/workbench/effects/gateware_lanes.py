"""Describes the corrections of the gateware: lanes, lanes that follow a condition, local errors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Lane:
    """A harmonic of head 1's error that a lane of the gateware can correct."""

    order: int
    cosine_arcsec: float
    sine_arcsec: float


Condition = Literal["direction", "speed", "speed_squared", "column"]
"""The conditions that the amplitude of a lane may follow (the gateware's generic MODULATORS).

``column``: a user's additional column of the set, whose present value the host measures and writes
to a register of the gateware.
"""


@dataclass(frozen=True, slots=True)
class ConditionedLane:
    """A harmonic of head 1's error that is proportional to a condition; order 0: a constant.

    Amplitudes are per unit of the condition: direction ±1, speed in rad/s or its square, or the
    column's unit.
    """

    condition: Condition
    lane: Lane
    column: str = ""
    """Name of the column, if the condition is a column."""
    column_zero: float = 0.0
    """Value of the column at which the condition is 0."""
    width_deg: float | None = None
    """Travel after a reversal within which the condition changes from one end of its range to the
    other; None if it is not known."""


@dataclass(frozen=True, slots=True)
class RealLane:
    """A harmonic of head 1's error at an order that is not an integer; its phase continues from
    turn to turn (the gateware's generic REAL_ORDERS)."""

    order: float
    cosine_arcsec: float
    sine_arcsec: float


@dataclass(frozen=True, slots=True)
class LocalError:
    """An error of head 1 at one place of the turn (the gateware's generic LOCAL_TABLE)."""

    place_rad: float
    """Reading of the head at the middle of the local error."""
    half_width_rad: float
    """Distance from the middle beyond which the error is negligible."""
    error_arcsec: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    """Function of the head's readings in radians, shape (n,), that returns the error."""


def paired_real_lanes(orders: Sequence[float], coefficients: NDArray[np.float64]) -> list[RealLane]:
    """Return one lane per order; ``coefficients`` are the cosine and sine of each order,
    (2·orders,)."""
    pairs = coefficients.reshape(-1, 2)
    return [
        RealLane(order, float(cosine), float(sine))
        for order, (cosine, sine) in zip(orders, pairs, strict=True)
    ]


def paired_lanes(orders: Sequence[int], coefficients: NDArray[np.float64]) -> list[Lane]:
    """Return one lane per order from the pairs of cosine and sine coefficients."""
    return [
        Lane(order, float(coefficients[2 * index]), float(coefficients[2 * index + 1]))
        for index, order in enumerate(orders)
    ]
