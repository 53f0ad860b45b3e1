"""Models ``rtl/decoder/edge_counter.vhd`` bit by bit: every output in every clock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.gateware.latest import earlier, latest, outputs, value_at, wrapped

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class CountedEdges:
    """Steps of the levels of A and B, (clocks,): element t compares clock t with clock t − 1."""

    step: Ints
    """1 for a step upwards, -1 for a step downwards, 0 for no step."""
    up: Bools
    """Whether the latest step was upwards; true if no step has come since the reset."""
    breaks_order: Bools


@dataclass(frozen=True)
class EdgeCounterTrace:
    """Outputs in every clock, shape (clocks + 1,): element t is the output during clock t."""

    position: Ints
    """Position, counts."""
    phase_of_zero: Ints
    """Index of the levels (A, B) in the sequence 00, 10, 11, 01 at position 0 modulo 4."""
    direction: Ints
    step: Ints
    step_up: Ints
    last_edge_time: NDArray[np.uint64]
    """Time of the latest edge, clocks."""


def counted_edges(a: Ints, b: Ints, preload: Bools, reset: Bools) -> CountedEdges:
    """Return the steps of the levels, (clocks,), compared with the levels of the previous clock."""
    a_before, b_before = earlier(a), earlier(b)
    valid = ~preload & ~reset
    a_changes, b_changes = a != a_before, b != b_before
    moves = (a_changes != b_changes) & valid
    # The count rises if A differs from the previous level of B, whichever of the two has changed.
    step = np.where(moves, np.where(a != b_before, 1, -1), 0)
    last_move = latest(moves)
    known = last_move > latest(reset)
    up = ~known | (value_at(last_move, step, 1) > 0)
    return CountedEdges(step, up, a_changes & b_changes & valid)


def edge_counter(
    a: Ints,
    b: Ints,
    preload: Bools,
    reset: Bools,
    timestamp: NDArray[np.uint64],
    reset_position: int = 0,
) -> EdgeCounterTrace:
    """Return the position and the other outputs for the levels ``a`` and ``b``, each (clocks,)."""
    edges = counted_edges(a, b, preload, reset)
    last_reset = latest(reset)
    # The position changes one clock after the step.
    moved = np.where(reset, 0, earlier(edges.step))
    moves = moved != 0
    total = np.cumsum(moved)
    position = reset_position + total - value_at(last_reset, total, 0)
    last_move = latest(moves)
    last_edge_time = np.where(
        last_move > last_reset, value_at(last_move, timestamp, 0), np.uint64(0)
    )
    # Index of the levels (A, B) at this position in the sequence 00, 10, 11, 01.
    place = 2 * b + (a ^ b)
    place = np.where(preload, place, earlier(place))
    phase_of_zero = np.where(reset | preload, 0, earlier((place - position) % 4))
    direction = np.where(reset, 1, earlier(edges.up.astype(np.int64)))
    direction[0] = 1
    return EdgeCounterTrace(
        position=outputs(0, wrapped(position)),
        phase_of_zero=outputs(0, phase_of_zero),
        direction=outputs(1, direction),
        step=outputs(0, moves),
        step_up=outputs(0, moved > 0),
        last_edge_time=np.concatenate([np.zeros(1, dtype=np.uint64), last_edge_time]),
    )
