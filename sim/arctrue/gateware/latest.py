"""Computes registers that hold a value from one event to the next, without a loop over the
clocks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def latest(event: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return for each clock the clock of the latest event, or -1 if there was none; (clocks,)."""
    return np.maximum.accumulate(np.where(event, np.arange(event.size), -1))


def value_at(clock: NDArray[np.int64], values: NDArray[Any], otherwise: int) -> NDArray[Any]:
    """Return ``values`` at the clocks ``clock``, and ``otherwise`` for a clock of -1; shape
    (clocks,)."""
    return np.where(clock >= 0, values[clock], values.dtype.type(otherwise))


def clock_before(clock: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the values of ``latest`` in the previous clock; -1 (none) in the first clock."""
    return np.concatenate([[-1], clock[:-1]])


def earlier(values: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the values in the previous clock; 0 in the first clock."""
    return np.concatenate([np.zeros_like(values[:1]), values[:-1]])


def was(event: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Tell for each clock whether the event occurred one clock earlier."""
    return np.concatenate([[False], event[:-1]])


def wrapped(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return counts as a signed 32-bit position, which wraps."""
    return (counts + 2**31) % 2**32 - 2**31


def outputs(begin: int, values: NDArray[Any]) -> NDArray[np.int64]:
    """Return the content of a register in every clock: ``begin`` at power-up, then its values after
    each clock."""
    return np.concatenate([[begin], values]).astype(np.int64)
