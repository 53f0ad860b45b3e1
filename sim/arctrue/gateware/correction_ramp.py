"""Model of the entity ``correction_ramp``: total = ε + r, without a step at a marker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arctrue.generated.number_formats import CORRECTION_FRACTION, PAIR_FRACTION

RATE_FRACTION = 24
RATE_MAX = 2**32 - 1
# Clocks from a marker to the first total from which r can have lost a unit.
DECAY_START = 2


@dataclass(frozen=True)
class RampState:
    """What the ramp remembers: the held total and r at the last marker, in 2⁻ᶠ count.

    ``age``: clocks since that marker.
    """

    held: int = 0
    caught: int = 0
    age: int = 0


class RampResult(NamedTuple):
    """``total``: int64 in 2⁻ᶠ count, F = PAIR_FRACTION; ``limited`` and ``busy``: bool."""

    total: NDArray[np.int64]
    limited: NDArray[np.bool_]
    busy: NDArray[np.bool_]
    state: RampState


def correction_ramp(
    correction: NDArray[np.int64],
    marker: NDArray[np.bool_],
    limit: int,
    ramp_rate: int,
    state: RampState | None = None,
    inserted: NDArray[np.int64] | None = None,
) -> RampResult:
    """The total correction of consecutive clocks.

    ``correction``: ε in 2⁻ᶠ count, (clocks,); ``marker``: (clocks,), true where ε comes from
    another origin than the clock before; ``limit`` in counts; ``ramp_rate`` u8.24 in 2⁻¹¹ count a
    clock. ``state``: that of the clocks before, else that after reset. ``inserted``: counts by
    which the reading jumps in the clock of a marker, (clocks,); not looked at in others.

    Raises ValueError for a rate that u8.24 cannot hold.
    """
    if not 0 <= ramp_rate <= RATE_MAX:
        raise ValueError(f"ramp_rate: {ramp_rate}, expected 0 to {RATE_MAX} (u8.24)")
    state = state or RampState()
    clocks = correction.size
    total = np.empty(clocks, dtype=np.int64)
    limited = np.zeros(clocks, dtype=np.bool_)
    busy = np.zeros(clocks, dtype=np.bool_)
    top = limit << PAIR_FRACTION
    markers = np.flatnonzero(marker).tolist()
    held, caught, age = state.held, state.caught, state.age
    start = 0
    for end in [*markers, clocks]:
        if end > start:
            ages = age + 1 + np.arange(end - start, dtype=np.int64)
            remainder = _decayed(caught, ages, ramp_rate)
            unlimited = correction[start:end] + remainder
            total[start:end] = np.clip(unlimited, -top, top)
            limited[start:end] = total[start:end] != unlimited
            busy[start:end] = remainder != 0
            held = int(total[end - 1])
            age = int(ages[-1])
        if end < clocks:
            if inserted is not None:
                held += int(inserted[end]) << PAIR_FRACTION
            total[end] = held
            busy[end] = True
            caught = held - int(correction[end])
            age = 0
        start = end + 1
    return RampResult(total, limited, busy, RampState(held, caught, age))


def _decayed(caught: int, ages: NDArray[np.int64], ramp_rate: int) -> NDArray[np.int64]:
    if caught == 0:
        return np.zeros(ages.size, dtype=np.int64)
    units = (np.maximum(ages - DECAY_START, 0) * ramp_rate) >> RATE_FRACTION
    lost = units << (PAIR_FRACTION - CORRECTION_FRACTION)
    left: NDArray[np.int64] = np.maximum(abs(caught) - lost, 0)
    return left if caught > 0 else -left
