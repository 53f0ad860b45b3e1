"""Models ``rtl/decoder/index_zero.vhd`` bit by bit: every output in every clock."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.gateware.edge_counter import CountedEdges
from arctrue.gateware.latest import (
    clock_before,
    earlier,
    latest,
    outputs,
    value_at,
    was,
    wrapped,
)
from arctrue.generated.number_formats import INDEX_HEAL_WIDTH, INDEX_JUDGED_AFTER, INDEX_SKEW

HEALED_MOST = 1 << (INDEX_HEAL_WIDTH - 1)
"""Limit of the slips that are healed: −HEALED_MOST to HEALED_MOST − 1 counts. A slip is the
distance of a new zero from the previous zero. To heal a slip, its counts are put back."""

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class IndexZeroTrace:
    """Outputs in every clock, shape (clocks + 1,): element t is the output during clock t.

    Values are in counts unless another unit is stated.
    """

    angle: Ints
    turn_position: Ints
    index_seen: Ints
    index_strobe: Ints
    index_position: Ints
    index_direction: Ints
    index_interval: Ints
    index_trusted: Ints
    zero_moved: Ints
    zero_moves: Ints
    zero_slip: Ints
    put_back: Ints


def _index(z: Ints, step: Ints, unsettled: Bools) -> tuple[Bools, Bools, Ints]:
    """Return the clocks in which an index mark is passed, whether it is passed upwards, and the
    offset of its zero in counts; all (clocks,)."""
    clocks = z.size
    index, index_up = np.zeros(clocks, dtype=np.bool_), np.zeros(clocks, dtype=np.bool_)
    offset = np.zeros(clocks, dtype=np.int64)
    at = np.flatnonzero(step)
    if not at.size:
        return index, index_up, offset
    # The level that belongs to a step is sampled INDEX_SKEW clocks later, or just before the next
    # step if this comes earlier.
    following = np.append(at[1:], clocks + INDEX_SKEW)
    is_cut = following <= at + INDEX_SKEW
    decided = np.where(is_cut, following, at + INDEX_SKEW)
    level = z[np.minimum(np.where(is_cut, following - 1, decided), clocks - 1)]
    # ``before``: level at the previous step, or in the last clock of a reset between the two steps.
    last_unsettled = latest(unsettled)
    begun = last_unsettled[at]
    is_first = begun > np.append(-1, at[:-1])
    before = np.where(is_first, z[begun], np.append(0, level[:-1]))
    settled = np.where(is_first, begun, np.append(-1, decided[:-1]))
    # ``within``: level during the count before the step if this count lasted long enough; otherwise
    # ``before``.
    stays = at - settled > INDEX_SKEW
    within = np.where(stays, z[at - INDEX_SKEW - 1], before)
    up = step[at] > 0
    is_inside = (within != before) & ((within == 1) == up)
    whole = (decided < clocks) & (last_unsettled[np.minimum(decided, clocks - 1)] < at)
    passed = whole & (is_inside | ((level != within) & ((level == 1) == up)))
    clock = decided[passed]
    index[clock] = True
    index_up[clock] = up[passed]
    offset[clock] = np.where(up, -is_inside.astype(np.int64), 1)[passed]
    return index, index_up, offset


@dataclass(frozen=True)
class _Verdicts:
    """Results of the check of each index mark, in arrays (clocks,), one clock after the check."""

    is_judged: Bools
    misplaced: Bools
    agrees: Bools
    """Whether the mark lies one turn from the previous mark."""
    other_agrees: Bools
    can_move: Bools
    forgotten: Bools
    detected: Bools
    """Clocks in which a mark is detected, (clocks,)."""


def _moved_zeros(verdicts: _Verdicts) -> tuple[Bools, Bools]:
    """Return the clocks in which a mark becomes the zero, and the clocks in which a mark is
    trusted."""
    moved = np.zeros(verdicts.detected.size, dtype=np.bool_)
    trusted = np.zeros_like(moved)
    last_forgotten = latest(verdicts.forgotten)
    in_doubt_since = -1
    judged = verdicts.is_judged | verdicts.misplaced | verdicts.agrees
    for clock in np.flatnonzero(judged).tolist():
        if last_forgotten[clock] >= in_doubt_since:
            in_doubt_since = -1
        # ``is_last``: no other mark has been detected since the checked one.
        follows = verdicts.detected[max(clock - INDEX_JUDGED_AFTER, 0) : clock + 1].any()
        is_last = verdicts.is_judged[clock] and not follows and not verdicts.forgotten[clock]
        is_proven = (verdicts.agrees[clock] and in_doubt_since >= 0) or (
            verdicts.misplaced[clock] and verdicts.other_agrees[clock]
        )
        if is_proven and verdicts.can_move[clock] and is_last:
            moved[clock] = True
            in_doubt_since = -1
        elif verdicts.misplaced[clock] and not verdicts.forgotten[clock]:
            in_doubt_since = clock
        trusted[clock] = is_last and in_doubt_since < 0
    return moved, trusted


def _slips(zero: Ints, at: Ints, begins: Bools, turn: Ints) -> Ints:
    """Return the slip of each mark that becomes the zero, in counts from −½ to below ½ turn."""
    slips = np.zeros(at.size, dtype=np.int64)
    last_begin = latest(begins)
    last_moved = -1
    for place, clock in enumerate(at.tolist()):
        of_before = max(int(clock_before(last_begin)[clock]), last_moved)
        angle = int(zero[clock] - zero[of_before]) % int(turn[clock])
        slips[place] = angle - turn[clock] if 2 * angle >= turn[clock] else angle
        last_moved = clock
    return slips


def index_zero(
    z: Ints,
    edges: CountedEdges,
    position: Ints,
    *,
    counts_per_rev: Ints,
    index_tolerance: Ints,
    rearm: Bools,
    zero_again: Bools,
    heal: Bools,
    other_head_agrees: Bools,
    preload: Bools,
    reset: Bools,
) -> tuple[IndexZeroTrace, Bools]:
    """Return the outputs, and the clocks, (clocks,), with an index error: a misplaced mark, or a
    zero that moved.

    ``position`` is the position of the entity edge_counter after each clock; edge_counter counts
    the edges ``edges``.

    Raises ValueError if a ``counts_per_rev`` that the entity samples is outside 4 to 2**24.
    """
    clocks = np.arange(reset.size)
    taken_over = reset | preload | rearm
    turn = value_at(latest(taken_over), counts_per_rev, 0)
    illegal_turn = np.flatnonzero(taken_over & ((turn < 4) | (turn > 2**24)))
    if illegal_turn.size:
        at = illegal_turn[0]
        raise ValueError(f"counts_per_rev is {turn[at]} in clock {at}; expected 4 to {2**24}")

    last_reset = latest(reset)
    moved = np.where(reset, 0, earlier(edges.step))
    total = np.cumsum(moved)
    passed, passed_up, offset = _index(z, edges.step, preload | reset)

    # The zero is the position at the last reset or rearm, or at the first index after it. A later
    # mark can become the zero, too; this is computed further below.
    forgotten = reset | rearm
    index = was(passed) & ~forgotten
    index_up = was(passed_up)
    # Counts from the zero to the position, without the step of this clock.
    behind_zero = np.where(index, moved - earlier(offset), 0)
    last_forgotten = latest(forgotten)
    index_number = np.cumsum(index) - value_at(last_forgotten, np.cumsum(index), 0)
    first_index = index & (index_number == 1)
    zero = total - behind_zero
    turn_in_force = np.maximum(earlier(turn), 1)

    # Stage 3 handles the index, one clock after the position.
    strobe = was(index) & ~forgotten
    latched = wrapped(earlier(position - behind_zero))
    last_strobe = latest(strobe)
    index_valid = last_strobe > last_reset
    repeated = strobe & (earlier(index_number) > 1)
    latched_before = value_at(clock_before(last_strobe), latched, 0)
    interval = np.where(repeated, wrapped(latched - latched_before), 0)
    size = np.abs(interval)
    deviation = np.minimum(size, np.abs(size - turn_in_force))
    # A mark is checked two clocks after it was latched, with the tolerance in the clock of the
    # check.
    judged = was(was(repeated) & ~reset)
    misplaced = judged & (earlier(earlier(deviation)) > index_tolerance)
    of_a_turn = earlier(earlier(np.abs(size - turn_in_force)))
    agrees = judged & (of_a_turn <= index_tolerance)
    can_move = zero_again & ~forgotten & (turn_in_force > 8)
    verdicts = _Verdicts(
        was(was(was(strobe) & ~forgotten) & ~forgotten),
        was(misplaced & ~reset),
        was(agrees & ~reset),
        other_head_agrees,
        can_move,
        forgotten,
        was(passed),
    )
    moved_zero, trusted = _moved_zeros(verdicts)
    at = np.flatnonzero(moved_zero)
    # The new zero is that of the checked mark, which was detected INDEX_JUDGED_AFTER + 1 clocks
    # earlier.
    zero[at] = zero[at - INDEX_JUDGED_AFTER - 1]
    slip = np.zeros(clocks.size, dtype=np.int64)
    slip[at] = _slips(zero, at, forgotten | first_index, turn_in_force)
    is_healed = heal & (np.abs(slip + 0.5) < HEALED_MOST)
    moves_total, healed_total = np.cumsum(slip != 0), -np.cumsum(np.where(is_healed, slip, 0))
    zero_moves = moves_total - value_at(last_reset, moves_total, 0)
    last_slip = latest(slip != 0)
    from_zero = total - value_at(latest(forgotten | first_index | moved_zero), zero, 0)
    detected = was(misplaced & ~reset) | (slip != 0)
    trace = IndexZeroTrace(
        angle=outputs(0, from_zero % turn_in_force),
        turn_position=outputs(0, wrapped(from_zero)),
        index_seen=outputs(0, index_number > 0),
        index_strobe=outputs(0, strobe),
        index_position=outputs(0, np.where(index_valid, value_at(last_strobe, latched, 0), 0)),
        index_direction=outputs(
            1,
            np.where(index_valid, value_at(last_strobe, earlier(index_up.astype(np.int64)), 1), 1),
        ),
        index_interval=outputs(
            0, np.where(last_strobe > last_forgotten, value_at(last_strobe, interval, 0), 0)
        ),
        index_trusted=outputs(0, trusted),
        zero_moved=outputs(0, zero_moves % 2),
        zero_moves=outputs(0, zero_moves % 2**16),
        zero_slip=outputs(0, np.where(last_slip > last_reset, value_at(last_slip, slip, 0), 0)),
        put_back=outputs(0, wrapped(healed_total - value_at(last_reset, healed_total, 0))),
    )
    return trace, detected
