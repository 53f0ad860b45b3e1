"""Models the entity ``turn_offset_sweep``, which computes the phase offset Φ + frac(m·ν) of each
lane for turn m; ν is the fractional part of the order of the lane."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.generated.number_formats import (
    PHASE_STEP_WIDTH,
    PHASE_WIDTH,
    REAL_ORDER_COUNTS_A_LANE,
    REAL_ORDER_COUNTS_FURTHER,
    TURN_SWEEP_CLOCKS_A_LANE,
)

PLACES: Final = 4
"""Number of turns for which offsets are stored; the offsets of turn m are stored at m modulo 4."""
_CUT_OFF = PHASE_STEP_WIDTH - PHASE_WIDTH


def ready_clocks(lanes: int) -> int:
    """Return the largest number of clocks from a wrap, at which a turn begins, until the offsets of
    the following turn are ready."""
    return 2 * TURN_SWEEP_CLOCKS_A_LANE * lanes + 12


def least_counts(lanes: int) -> int:
    """Return the smallest number of counts per turn for which the offsets are ready in time at one
    count per clock.

    Between two wraps in one direction the angle travels at least half a turn, because a moved zero
    may skip the other half.
    """
    return REAL_ORDER_COUNTS_A_LANE * lanes + REAL_ORDER_COUNTS_FURTHER


def turn_offsets(
    turn: ArrayLike, turn_steps: ArrayLike, phase_offsets: ArrayLike
) -> NDArray[np.int64]:
    """Return the phase offsets in 2⁻²⁴ turn, (turns, lanes), rounded once, half up.

    ``turn``: numbers of turns m, (turns,); ``turn_steps``: ν in 2⁻⁴⁸ turn per turn and
    ``phase_offsets``: Φ in 2⁻²⁴ turn, (lanes,).
    """
    # Products wrap modulo 2⁶⁴. This does not change the 48 low bits, which hold the fraction of a
    # turn.
    numbers = np.asarray(turn, dtype=np.int64).astype(np.uint64)[..., np.newaxis]
    fraction = numbers * np.asarray(turn_steps, dtype=np.uint64)
    fraction = (fraction + np.uint64(1 << (_CUT_OFF - 1))) >> np.uint64(_CUT_OFF)
    offsets = fraction.astype(np.int64) + np.asarray(phase_offsets, dtype=np.int64)
    wrapped: NDArray[np.int64] = offsets & ((1 << PHASE_WIDTH) - 1)
    return wrapped
