"""Models the entity ``error_compensation``: θ_com = R − ε(R) of equation (8)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arctrue.gateware.correction_ramp import RampState, correction_ramp
from arctrue.generated.number_formats import (
    AMPLITUDE_FRACTION,
    CORRECTION_FRACTION,
    CORRECTION_WIDTH,
    LOCAL_VALUE_FRACTION,
    MEAN_TERM_FRACTION,
    PAIR_FRACTION,
    POSITION_WIDTH,
)

LIMIT_MAX_COUNTS = (1 << (CORRECTION_WIDTH - 1 - CORRECTION_FRACTION)) - 1


class Subtracted(NamedTuple):
    """Outputs of the gateware: corrected angle and position in counts, correction in 2⁻¹¹ count,
    int64."""

    corrected_angle: NDArray[np.int64]
    corrected_position: NDArray[np.int64]
    correction: NDArray[np.int64]


class Compensated(NamedTuple):
    """Outputs of the entity, one per clock, and the state after the last clock."""

    corrected_angle: NDArray[np.int64]
    corrected_position: NDArray[np.int64]
    correction: NDArray[np.int64]
    correction_limited: NDArray[np.bool_]
    ramp_busy: NDArray[np.bool_]
    state: CompensationState


@dataclass(frozen=True)
class CompensationState:
    """Registers of the entity; the default is the state after reset."""

    applied: bool = False
    zero_moved: bool = False
    put_back: int = 0
    ramp: RampState = field(default_factory=RampState)


def correction_limit(counts_per_rev: int) -> int:
    """Return the largest permitted correction in counts: below half a turn, and within s19.11."""
    return min((counts_per_rev - 1) // 2, LIMIT_MAX_COUNTS)


def add_pairs(
    pair_sums: NDArray[np.int64],
    offset: int | NDArray[np.int64],
    local_value: NDArray[np.int64] | None = None,
) -> NDArray[np.int64]:
    """Return ε in 2⁻ᶠ count, (clocks,), F = PAIR_FRACTION: the sum of pairs, offset and local
    table.

    ``pair_sums``: (clocks, pairs) in 2⁻ᶠ count; ``offset``: in 2⁻¹¹ count, one or one per clock;
    ``local_value``: value of the local table in 2⁻²² count, (clocks,).
    """
    aligned = np.asarray(offset, dtype=np.int64) << (PAIR_FRACTION - AMPLITUDE_FRACTION)
    total: NDArray[np.int64] = pair_sums.sum(axis=-1, dtype=np.int64) + aligned
    if local_value is not None:
        total += local_value << (PAIR_FRACTION - LOCAL_VALUE_FRACTION)
    return total


def subtract(
    angle: NDArray[np.int64],
    position: NDArray[np.int64],
    total: NDArray[np.int64],
    counts_per_rev: int,
) -> Subtracted:
    """Return R − floor(total + ½): the total correction is rounded once and subtracted.

    ``angle`` and ``position`` in counts, ``total`` in 2⁻ᶠ count, all (clocks,). The angle wraps at
    one turn, the position at 32 bits with sign.
    """
    rounded = (total + (1 << (PAIR_FRACTION - 1))) >> PAIR_FRACTION
    half = 1 << (POSITION_WIDTH - 1)
    return Subtracted(
        (angle - rounded) % counts_per_rev,
        ((position - rounded + half) & (2 * half - 1)) - half,
        total >> (PAIR_FRACTION - CORRECTION_FRACTION),
    )


def error_compensation(
    pair_sums: NDArray[np.int64],
    offset: int | NDArray[np.int64],
    angle: NDArray[np.int64],
    position: NDArray[np.int64],
    apply: NDArray[np.bool_],
    swap_marker: NDArray[np.bool_],
    counts_per_rev: int,
    ramp_rate: int,
    state: CompensationState | None = None,
    zero_moved: NDArray[np.bool_] | None = None,
    put_back: NDArray[np.int64] | None = None,
    mean_term: NDArray[np.int64] | None = None,
    jump: NDArray[np.int64] | None = None,
) -> Compensated:
    """Return the outputs for the inputs of consecutive clocks; the latency of 4 clocks is omitted.

    ``pair_sums``: (clocks, pairs) in 2⁻ᶠ count; ``angle`` and ``position``: counts, (clocks,);
    ``apply`` and ``swap_marker``: (clocks,). ``state``: the state after the previous clocks,
    default: after reset. ``zero_moved`` toggles at the first angle that counts from a new zero;
    ``put_back``: counts in ``position`` that did not come from an edge; both (clocks,), default:
    the values of ``state``. ``mean_term`` and ``jump``, both (clocks,), are for the mean of the
    heads. ``mean_term`` is in 2⁻²⁰ count. ``jump`` is the number of counts by which the reading
    jumps at the first angle that uses new words of the mean (``swap_marker`` is true there), and 0
    at all other angles.
    """
    state = state or CompensationState()
    moved = np.full(apply.shape, state.zero_moved) if zero_moved is None else zero_moved
    healed = np.full(apply.shape, state.put_back) if put_back is None else put_back
    moved_before = np.concatenate(([state.zero_moved], moved[:-1]))
    healed_before = np.concatenate(([state.put_back], healed[:-1]))
    moves = moved != moved_before
    applied_before = np.concatenate(([state.applied], apply[:-1]))
    summed = add_pairs(pair_sums, offset)
    if mean_term is not None:
        summed = summed + (mean_term << (PAIR_FRACTION - MEAN_TERM_FRACTION))
    unramped = np.where(apply, summed, 0)
    withdrawn = np.where(moves, (healed - healed_before + 2**15) % 2**16 - 2**15, 0)
    if jump is not None:
        withdrawn = np.where(jump != 0, jump, withdrawn)
    ramped = correction_ramp(
        unramped,
        swap_marker | (apply != applied_before) | moves,
        correction_limit(counts_per_rev),
        ramp_rate,
        state.ramp,
        withdrawn,
    )
    subtracted = subtract(angle, position, ramped.total, counts_per_rev)
    if apply.size:
        after = CompensationState(bool(apply[-1]), bool(moved[-1]), int(healed[-1]), ramped.state)
    else:
        after = replace(state, ramp=ramped.state)
    return Compensated(*subtracted, ramped.limited, ramped.busy, after)
