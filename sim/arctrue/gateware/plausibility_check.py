"""Models ``rtl/decoder/plausibility_check.vhd`` bit by bit: every output in every clock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.gateware.edge_counter import CountedEdges
from arctrue.gateware.latest import clock_before, earlier, latest, outputs, value_at, was
from arctrue.generated.number_formats import COUNTS_PER_PERIOD, EDGE_SPACING_MAX, FAULT_COUNT_MAX

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class PlausibilityTrace:
    """Outputs in every clock, shape (clocks + 1,): element t is the output during clock t."""

    index_error: Ints
    index_error_count: Ints
    illegal: Ints
    illegal_count: Ints
    overspeed: Ints
    overspeed_count: Ints
    swallowed: Ints
    """Whether the filter suppressed counts."""


def _edges_lost(
    levels: tuple[Ints, Ints],
    filter_length: Ints,
    edges: CountedEdges,
    settling: Bools,
) -> Bools:
    """Return for each clock whether the check detects that the filter suppressed a whole period of
    A and B, or four illegal transitions.

    ``levels``: A and B before the filter; ``settling``: clocks in which they are ignored.
    """
    a, b = levels
    a_before, b_before = earlier(a), earlier(b)
    a_changes, b_changes = a != a_before, b != b_before
    moves = np.where(a_changes != b_changes, np.where(a != b_before, 1, -1), 0)
    still = np.minimum(np.arange(a.size) - latest(a_changes | b_changes) - 1, 255)
    quiet = ~(a_changes | b_changes) & (still >= filter_length)
    # The entity adds the steps one clock later.
    moved, breaks = earlier(moves), was(a_changes & b_changes)
    filtered_moved, filtered_breaks = earlier(edges.step), was(edges.breaks_order)
    starts_anew = settling | was(quiet)
    last_start = latest(starts_anew).tolist()
    event = ((moved != filtered_moved) | breaks | filtered_breaks) & ~starts_anew
    lost = np.zeros(a.size, dtype=np.bool_)
    ahead = hidden = before = 0
    columns = (moved - filtered_moved, breaks, filtered_breaks)
    clocks = np.flatnonzero(event)
    rows = zip(clocks.tolist(), *(column[clocks].tolist() for column in columns), strict=True)
    for clock, gained, is_broken, is_reported in rows:
        if last_start[clock] > before:
            ahead = hidden = 0
        before = clock
        ahead += gained
        hidden = 0 if is_reported else hidden + is_broken
        if abs(ahead) >= COUNTS_PER_PERIOD or hidden == COUNTS_PER_PERIOD:
            lost[clock] = True
            ahead = hidden = 0
    return lost


def _sticky(event: Bools, clear: Bools, reset: Bools) -> tuple[Ints, Ints]:
    """Return flag and counter after each clock; an event in the same clock as a clear still
    counts."""
    total = np.cumsum(event)
    gone = np.where(reset, total, total - event)
    count = total - value_at(latest(clear | reset), gone, 0)
    return (count > 0).astype(np.int64), np.minimum(count, FAULT_COUNT_MAX)


def plausibility_check(
    levels: tuple[Ints, Ints],
    edges: CountedEdges,
    misplaced: Bools,
    *,
    filter_length: Ints,
    minimum_edge_spacing: Ints,
    clear: Bools,
    settling: Bools,
    reset: Bools,
) -> PlausibilityTrace:
    """Return the faults of a head; all arrays have the shape (clocks,).

    ``levels``: A and B before the filter; ``edges``: edges of the filtered levels; ``settling``:
    clocks in which the levels before the filter are ignored.
    """
    moves = np.where(reset, 0, earlier(edges.step)) != 0
    last_move = latest(moves)
    move_before = clock_before(last_move)
    # The spacing of edges is measured one clock after the position changes.
    spacing = np.minimum(np.arange(clear.size) - move_before, EDGE_SPACING_MAX)
    spacing = np.where(move_before > latest(reset), spacing, EDGE_SPACING_MAX)
    too_near = moves & (spacing < minimum_edge_spacing)

    illegal, illegal_count = _sticky(was(edges.breaks_order) & ~reset, clear, reset)
    edges_lost = _edges_lost(levels, filter_length, edges, settling)
    too_fast = was((too_near | edges_lost) & ~reset) & ~reset
    overspeed, overspeed_count = _sticky(too_fast, clear, reset)
    swallowed, _ = _sticky(was(edges_lost & ~reset) & ~reset, clear, reset)
    index_error, index_error_count = _sticky(misplaced & ~reset, clear, reset)
    return PlausibilityTrace(
        index_error=outputs(0, index_error),
        index_error_count=outputs(0, index_error_count),
        illegal=outputs(0, illegal),
        illegal_count=outputs(0, illegal_count),
        overspeed=outputs(0, overspeed),
        overspeed_count=outputs(0, overspeed_count),
        swallowed=outputs(0, swallowed),
    )
