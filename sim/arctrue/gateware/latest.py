"""Registers that hold a value from one event to the next, without a loop over the clocks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def latest(event: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Clock of the latest event at or before each clock, -1 before the first; shape (clocks,)."""
    return np.maximum.accumulate(np.where(event, np.arange(event.size), -1))


def value_at(clock: NDArray[np.int64], values: NDArray[Any], otherwise: int) -> NDArray[Any]:
    """``values`` at ``clock``, and ``otherwise`` where that is -1; shape (clocks,)."""
    return np.where(clock >= 0, values[clock], values.dtype.type(otherwise))
