"""Models the entity ``compensation_pipeline``, equations (8) and (9), bit by bit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.error_compensation import (
    Compensated,
    CompensationState,
    Subtracted,
    add_pairs,
    correction_limit,
    error_compensation,
    subtract,
)
from arctrue.gateware.harmonic_lane import Rotation
from arctrue.gateware.harmonic_unit import harmonic_unit
from arctrue.gateware.local_table import LocalTable, local_table
from arctrue.gateware.phase_unit import phase_unit
from arctrue.gateware.turn_offset_sweep import turn_offsets
from arctrue.generated.number_formats import COSINE_WIDTH, PAIR_FRACTION

# Number of angles that are processed at a time; their phases and cosines then fit the processor's
# cache.
_BLOCK = 2048


def pair_sums(
    angle: NDArray[np.int64],
    coefficients: Coefficients,
    cosine_width: int = COSINE_WIDTH,
    rotation: Rotation = "cordic",
    turns: NDArray[np.int64] | None = None,
) -> NDArray[np.int64]:
    """Return the sums of pairs of harmonics at ``angle`` (counts, (clocks,)): (clocks, pairs).

    The unit is 2⁻ᶠ count, F = PAIR_FRACTION. ``turns``: turn number of each angle, (clocks,), of a
    core with REAL_ORDERS; None: all 0.
    """
    sums = np.empty((angle.size, (coefficients.lanes + 1) // 2), dtype=np.int64)
    for start in range(0, angle.size, _BLOCK):
        block = slice(start, start + _BLOCK)
        offsets: NDArray[Any] = coefficients.phase_offsets
        if turns is not None:
            offsets = turn_offsets(turns[block], coefficients.turn_steps, offsets)
        phases = phase_unit(angle[block], coefficients.phase_steps, offsets)
        sums[block] = harmonic_unit(
            phases, coefficients.amplitudes, cosine_width, rotation=rotation
        )
    return sums


def compensate(
    angle: ArrayLike,
    position: ArrayLike,
    coefficients: Coefficients,
    cosine_width: int = COSINE_WIDTH,
    rotation: Rotation = "cordic",
    table: LocalTable | None = None,
    turns: NDArray[np.int64] | None = None,
) -> Subtracted:
    """Return the outputs in the settled state: compensation on, no ramp active.

    ``angle``: counts, 0 <= angle < counts_per_rev, and ``position``: counts, both (readings,).
    ``table``: local table of a core with LOCAL_TABLE; ``turns``: turn numbers, (readings,), of a
    core with REAL_ORDERS. Returns corrected angle and position in counts and the correction in 2⁻¹¹
    count, int64.

    Raises ValueError for an angle outside the turn.
    """
    angles, positions = _readings(angle, position, coefficients.counts_per_rev)
    limit = correction_limit(coefficients.counts_per_rev) << PAIR_FRACTION
    sums = pair_sums(angles, coefficients, cosine_width, rotation, turns)
    value = None if table is None else local_table(angles, table)
    total = add_pairs(sums, coefficients.offset, value)
    return subtract(angles, positions, np.clip(total, -limit, limit), coefficients.counts_per_rev)


def compensate_clocks(
    angle: ArrayLike,
    position: ArrayLike,
    banks: Sequence[Coefficients],
    bank: ArrayLike,
    swap_marker: ArrayLike,
    apply: ArrayLike,
    ramp_rate: int,
    state: CompensationState | None = None,
    cosine_width: int = COSINE_WIDTH,
    fold: int = 1,
    rotation: Rotation = "cordic",
    turns: ArrayLike | None = None,
) -> Compensated:
    """Return the outputs of consecutive clocks, with swaps, enable and bypass, but without the
    latency.

    ``bank``: index into ``banks`` for the angle of each clock; ``swap_marker``: true with the first
    angle after each swap; ``apply``: level of the port of this name; all (clocks,). ``ramp_rate``:
    u8.24 in 2⁻¹¹ count per clock. ``state``: the state after the previous clocks, default: after
    reset. ``fold``: the gateware accepts the angle of the first clock and then one angle every
    ``fold`` clocks; the inputs of other clocks are ignored. The omitted latency is 28 + ``fold``
    clocks. ``turns``: turn number of the angle of each clock, (clocks,), of a core with
    REAL_ORDERS. Raises ValueError for an angle outside the turn, banks for different turns or
    lanes, or a number of lanes that is not a multiple of ``fold``.
    """
    if len({(entry.counts_per_rev, entry.lanes) for entry in banks}) != 1:
        raise ValueError("banks: expected at least one, all for the same counts_per_rev and lanes")
    counts_per_rev = banks[0].counts_per_rev
    if banks[0].lanes % fold:
        raise ValueError(f"{banks[0].lanes} lanes cannot be folded by {fold}")
    angles, positions = _readings(angle, position, counts_per_rev)
    clocks = angles.size
    angles, positions = angles[::fold], positions[::fold]
    of_clock = np.asarray(bank, dtype=np.int64)[::fold]
    numbers = np.zeros(clocks, dtype=np.int64) if turns is None else np.asarray(turns)
    numbers = numbers[::fold]
    sums = np.empty((angles.size, (banks[0].lanes + 1) // 2), dtype=np.int64)
    for index, entry in enumerate(banks):
        met = of_clock == index
        sums[met] = pair_sums(angles[met], entry, cosine_width, rotation, numbers[met])
    offsets = np.array([entry.offset for entry in banks], dtype=np.int64)[of_clock]
    # A reading stays constant for ``fold`` clocks; its swap marker is set only in the first of
    # these clocks.
    marker = np.zeros(clocks, dtype=np.bool_)
    marker[::fold] = np.asarray(swap_marker, dtype=np.bool_)[::fold]
    return error_compensation(
        _held(sums, fold, clocks),
        _held(offsets, fold, clocks),
        _held(angles, fold, clocks),
        _held(positions, fold, clocks),
        _held(np.asarray(apply, dtype=np.bool_)[::fold], fold, clocks),
        marker,
        counts_per_rev,
        ramp_rate,
        state,
    )


def _held(accepted: NDArray[Any], fold: int, clocks: int) -> NDArray[Any]:
    """Repeat each entry of ``accepted`` for ``fold`` clocks; return (clocks, …)."""
    return accepted if fold == 1 else np.repeat(accepted, fold, axis=0)[:clocks]


def _readings(
    angle: ArrayLike, position: ArrayLike, counts_per_rev: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    angles = np.asarray(angle, dtype=np.int64)
    positions = np.asarray(position, dtype=np.int64)
    if angles.shape != positions.shape or angles.ndim != 1:
        raise ValueError(
            "expected one angle and one position per reading: found shapes "
            f"{angles.shape}, {positions.shape}"
        )
    outside = np.flatnonzero((angles < 0) | (angles >= counts_per_rev))
    if outside.size:
        raise ValueError(
            f"angle[{outside[0]}]: {angles[outside[0]]}, expected 0 to {counts_per_rev - 1} counts"
        )
    return angles, positions
