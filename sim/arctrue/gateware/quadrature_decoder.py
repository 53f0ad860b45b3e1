"""Bit-true model of ``rtl/decoder/quadrature_decoder.vhd``: every output in every clock.

The registers are sums and latest values over whole arrays, not a walk from clock to clock.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.glitch_filter import glitch_filter
from arctrue.gateware.input_synchroniser import STAGES_DEFAULT, input_synchroniser
from arctrue.gateware.latest import latest, value_at
from arctrue.generated.number_formats import INDEX_SKEW

COUNTER_MAX = 2**16 - 1
"""The fault counters stop here."""

JUDGED_AFTER = 3
"""Clocks from an index told to its judgement."""

HEALED_MOST = 2**14
"""Counts: a slip of so many and more is not put back."""

PERIOD = 4
"""Counts of a period of A and B."""

SPACING_MAX = 2**16 - 1
"""The spacing of edges is measured up to here, clocks."""

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


def latency_clocks(filter_length: int = 1, stages: int = STAGES_DEFAULT) -> int:
    """Clocks from a change of a pin to the position."""
    return stages + max(filter_length, 1) + 2


@dataclass(frozen=True)
class DecoderInputs:
    """What the decoder sees, one value a clock or one for all clocks."""

    a: ArrayLike
    b: ArrayLike
    z: ArrayLike = 0
    counts_per_rev: ArrayLike = 2**24
    """Counts, 4 to 2**24."""
    filter_length: ArrayLike = 1
    """Clocks, 1 is off."""
    minimum_edge_spacing: ArrayLike = 0
    """Clocks, 0 is off."""
    index_tolerance: ArrayLike = 0
    """Counts."""
    timestamp: ArrayLike = 0
    """Clocks, 0 to 2**64 - 1."""
    clear: ArrayLike = False
    rearm: ArrayLike = False
    zero_again: ArrayLike = False
    heal: ArrayLike = False
    other_head_agrees: ArrayLike = False
    reset: ArrayLike = False


@dataclass(frozen=True)
class DecoderTrace:
    """Every output in every clock, shape (clocks + 1,), counts unless said otherwise.

    Element t is the output during clock t; the last one follows the last input.
    """

    position: Ints
    angle: Ints
    turn_position: Ints
    phase_of_zero: Ints
    """Place of (A, B) in 00, 10, 11, 01 at position 0 modulo 4."""
    direction: Ints
    step: Ints
    step_up: Ints
    last_edge_time: NDArray[np.uint64]
    """Clocks."""
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
    index_error: Ints
    index_error_count: Ints
    illegal: Ints
    illegal_count: Ints
    overspeed: Ints
    overspeed_count: Ints
    swallowed: Ints
    """The filter swallowed counts."""


@dataclass(frozen=True)
class _Events:
    """Stage 1: what the filtered levels say. Shape (clocks,), known after that clock."""

    step: Ints
    up: Bools
    illegal: Bools
    index: Bools
    """Told in this clock, of the step before."""
    index_up: Bools
    index_offset: Ints
    """From the position after the last step to the zero, counts."""


def _wrapped(value: Ints) -> Ints:
    return (value + 2**31) % 2**32 - 2**31


def _earlier(values: Ints) -> Ints:
    """Values one clock ago, 0 in the first clock."""
    return np.concatenate([np.zeros_like(values[:1]), values[:-1]])


def _clock_before(clock: Ints) -> Ints:
    """The clock found one clock ago, -1 (none) in the first clock."""
    return np.concatenate([[-1], clock[:-1]])


def _was(event: Bools) -> Bools:
    """Whether the event was one clock ago."""
    return np.concatenate([[False], event[:-1]])


def _events(a: Ints, b: Ints, z: Ints, preload: Bools, reset: Bools) -> _Events:
    a_before, b_before = _earlier(a), _earlier(b)
    valid = ~preload & ~reset
    a_changes, b_changes = a != a_before, b != b_before
    moves = (a_changes != b_changes) & valid
    # A leads B upwards: whichever of them changed, A now differs from the earlier B.
    step = np.where(moves, np.where(a != b_before, 1, -1), 0)
    last_move = latest(moves)
    known = last_move > latest(reset)
    up = ~known | (value_at(last_move, step, 1) > 0)
    return _Events(step, up, a_changes & b_changes & valid, *_index(z, step, ~valid))


def _index(z: Ints, step: Ints, unsettled: Bools) -> tuple[Bools, Bools, Ints]:
    """The passages of the index, the ways, and where their zeros lie; each (clocks,)."""
    clocks = z.size
    index, index_up = np.zeros(clocks, dtype=np.bool_), np.zeros(clocks, dtype=np.bool_)
    offset = np.zeros(clocks, dtype=np.int64)
    at = np.flatnonzero(step)
    if not at.size:
        return index, index_up, offset
    # The level of a step: so many clocks later, or just before the next step.
    following = np.append(at[1:], clocks + INDEX_SKEW)
    is_cut = following <= at + INDEX_SKEW
    told = np.where(is_cut, following, at + INDEX_SKEW)
    level = z[np.minimum(np.where(is_cut, following - 1, told), clocks - 1)]
    # That of the step before, or of the last clock of a reset between them.
    last_unsettled = latest(unsettled)
    begun = last_unsettled[at]
    is_first = begun > np.append(-1, at[:-1])
    before = np.where(is_first, z[begun], np.append(0, level[:-1]))
    settled = np.where(is_first, begun, np.append(-1, told[:-1]))
    # What it was in the count before the step, where that lasted long enough.
    stays = at - settled > INDEX_SKEW
    within = np.where(stays, z[at - INDEX_SKEW - 1], before)
    up = step[at] > 0
    is_inside = (within != before) & ((within == 1) == up)
    whole = (told < clocks) & (last_unsettled[np.minimum(told, clocks - 1)] < at)
    passed = whole & (is_inside | ((level != within) & ((level == 1) == up)))
    clock = told[passed]
    index[clock] = True
    index_up[clock] = up[passed]
    offset[clock] = np.where(up, -is_inside.astype(np.int64), 1)[passed]
    return index, index_up, offset


def _edges_lost(
    levels: tuple[Ints, Ints],
    filter_length: Ints,
    seen: _Events,
    settling: Bools,
) -> Bools:
    """Clocks in which the levels before the filter turn out to be a period ahead of the others.

    ``levels``: A and B before the filter; ``settling``: clocks in which they are not looked at.
    """
    a, b = levels
    a_before, b_before = _earlier(a), _earlier(b)
    a_changes, b_changes = a != a_before, b != b_before
    moves = np.where(a_changes != b_changes, np.where(a != b_before, 1, -1), 0)
    still = np.minimum(np.arange(a.size) - latest(a_changes | b_changes) - 1, 255)
    quiet = ~(a_changes | b_changes) & (still >= filter_length)
    # One clock later they are summed up.
    moved, breaks = _earlier(moves), _was(a_changes & b_changes)
    filtered_moved, filtered_breaks = _earlier(seen.step), _was(seen.illegal)
    starts_anew = settling | _was(quiet)
    last_start = latest(starts_anew).tolist()
    event = ((moved != filtered_moved) | breaks | filtered_breaks) & ~starts_anew
    lost = np.zeros(a.size, dtype=np.bool_)
    ahead = hidden = before = 0
    columns = (moved - filtered_moved, breaks, filtered_breaks)
    clocks = np.flatnonzero(event)
    rows = zip(clocks.tolist(), *(column[clocks].tolist() for column in columns), strict=True)
    for clock, gained, is_broken, is_told in rows:
        if last_start[clock] > before:
            ahead = hidden = 0
        before = clock
        ahead += gained
        hidden = 0 if is_told else hidden + is_broken
        if abs(ahead) >= PERIOD or hidden == PERIOD:
            lost[clock] = True
            ahead = hidden = 0
    return lost


@dataclass(frozen=True)
class _Verdicts:
    """What each mark that is judged says; all (clocks,), in the clock of the verdict."""

    is_judged: Bools
    misplaced: Bools
    agrees: Bools
    """It lies a turn from the mark before it."""
    other_agrees: Bools
    can_move: Bools
    forgotten: Bools
    told: Bools
    """Clocks in which a mark is told."""


def _moved_zeros(verdicts: _Verdicts) -> tuple[Bools, Bools]:
    """Clocks in which a mark becomes the zero, and those in which one is trusted."""
    moved = np.zeros(verdicts.told.size, dtype=np.bool_)
    trusted = np.zeros_like(moved)
    last_forgotten = latest(verdicts.forgotten)
    in_doubt_since = -1
    judged = verdicts.is_judged | verdicts.misplaced | verdicts.agrees
    for clock in np.flatnonzero(judged).tolist():
        if last_forgotten[clock] >= in_doubt_since:
            in_doubt_since = -1
        # No other mark since the one that is judged.
        follows = verdicts.told[max(clock - JUDGED_AFTER, 0) : clock + 1].any()
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
    """The angle, -half a turn to half a turn, of each mark that becomes the zero; (at,)."""
    slips = np.zeros(at.size, dtype=np.int64)
    last_begin = latest(begins)
    last_moved = -1
    for place, clock in enumerate(at.tolist()):
        of_before = max(int(_clock_before(last_begin)[clock]), last_moved)
        angle = int(zero[clock] - zero[of_before]) % int(turn[clock])
        slips[place] = angle - turn[clock] if 2 * angle >= turn[clock] else angle
        last_moved = clock
    return slips


def _sticky(event: Bools, clear: Bools, reset: Bools) -> tuple[Ints, Ints]:
    """Flag and counter after each clock; an event in the clock of a clear is kept."""
    total = np.cumsum(event)
    gone = np.where(reset, total, total - event)
    count = total - value_at(latest(clear | reset), gone, 0)
    return (count > 0).astype(np.int64), np.minimum(count, COUNTER_MAX)


def quadrature_decoder(
    inputs: DecoderInputs, synchroniser_stages: int = STAGES_DEFAULT, reset_position: int = 0
) -> DecoderTrace:
    """Run the decoder over all clocks of ``inputs``, from power-up on.

    ``reset_position`` in counts is the position of the disc in the first clock after a reset.

    Raises ValueError when the shapes of the inputs do not fit, when there is no clock, or for a
    ``counts_per_rev`` outside 4 to 2**24 that is taken over.
    """
    columns = {field.name: np.atleast_1d(getattr(inputs, field.name)) for field in fields(inputs)}
    columns = dict(zip(columns, np.broadcast_arrays(*columns.values()), strict=True))
    timestamp = columns.pop("timestamp").astype(np.uint64)
    levels_of = ("clear", "rearm", "reset", "zero_again", "heal", "other_head_agrees")
    clear, rearm, reset, zero_again, heal, other_agrees = (
        columns.pop(name) != 0 for name in levels_of
    )
    if clear.size == 0:
        raise ValueError("the inputs hold no clock; expected one value a clock")
    column = {name: values.astype(np.int64) for name, values in columns.items()}
    clocks = np.arange(clear.size)

    # Until the synchroniser holds levels of the clock of the last reset.
    last_reset = latest(reset)
    since_reset = clocks - _clock_before(last_reset)
    preload = since_reset <= synchroniser_stages + 1
    filter_reset = since_reset <= synchroniser_stages
    levels = [input_synchroniser(column[pin], synchroniser_stages) for pin in ("a", "b", "z")]
    a, b, z = (glitch_filter(pin, column["filter_length"], filter_reset)[:-1] for pin in levels)
    seen = _events(a, b, z, preload, reset)

    taken_over = reset | preload | rearm
    turn = value_at(latest(taken_over), column["counts_per_rev"], 0)
    illegal_turn = np.flatnonzero(taken_over & ((turn < 4) | (turn > 2**24)))
    if illegal_turn.size:
        at = illegal_turn[0]
        raise ValueError(f"counts_per_rev is {turn[at]} in clock {at}; expected 4 to {2**24}")

    # Stage 2: position. A step counts one clock after it was seen.
    moved = np.where(reset, 0, _earlier(seen.step))
    moves = moved != 0
    total = np.cumsum(moved)
    from_reset = reset_position + total - value_at(last_reset, total, 0)
    last_move = latest(moves)
    last_edge_time = np.where(
        last_move > last_reset, value_at(last_move, timestamp, 0), np.uint64(0)
    )

    # The zero: where the last reset or rearm was, or the first index after it.
    forgotten = reset | rearm
    index = _was(seen.index) & ~forgotten
    index_up = _was(seen.index_up)
    # From the zero to the position: the step of this clock comes after it.
    behind_zero = np.where(index, moved - _earlier(seen.index_offset), 0)
    last_forgotten = latest(forgotten)
    index_number = np.cumsum(index) - value_at(last_forgotten, np.cumsum(index), 0)
    first_index = index & (index_number == 1)
    zero = total - behind_zero
    turn_in_force = np.maximum(_earlier(turn), 1)

    # Stage 3: the index, one clock after the position.
    strobe = _was(index) & ~forgotten
    latched = _wrapped(_earlier(from_reset - behind_zero))
    last_strobe = latest(strobe)
    index_valid = last_strobe > last_reset
    repeated = strobe & (_earlier(index_number) > 1)
    latched_before = value_at(_clock_before(last_strobe), latched, 0)
    interval = np.where(repeated, _wrapped(latched - latched_before), 0)
    size = np.abs(interval)
    deviation = np.minimum(size, np.abs(size - turn_in_force))
    # Judged two clocks after it was latched, by the tolerance of that clock.
    judged = _was(_was(repeated) & ~reset)
    misplaced = judged & (_earlier(_earlier(deviation)) > column["index_tolerance"])
    of_a_turn = _earlier(_earlier(np.abs(size - turn_in_force)))
    agrees = judged & (of_a_turn <= column["index_tolerance"])
    can_move = zero_again & ~forgotten & (turn_in_force > 8)
    verdicts = _Verdicts(
        _was(_was(_was(strobe) & ~forgotten) & ~forgotten),
        _was(misplaced & ~reset),
        _was(agrees & ~reset),
        other_agrees,
        can_move,
        forgotten,
        _was(seen.index),
    )
    moved_zero, trusted = _moved_zeros(verdicts)
    at = np.flatnonzero(moved_zero)
    # That of the mark, told so many clocks before.
    zero[at] = zero[at - JUDGED_AFTER - 1]
    slip = np.zeros(clocks.size, dtype=np.int64)
    slip[at] = _slips(zero, at, forgotten | first_index, turn_in_force)
    is_healed = heal & (np.abs(slip + 0.5) < HEALED_MOST)
    moves_total, healed_total = np.cumsum(slip != 0), -np.cumsum(np.where(is_healed, slip, 0))
    zero_moves = moves_total - value_at(last_reset, moves_total, 0)
    last_slip = latest(slip != 0)
    from_zero = total - value_at(latest(forgotten | first_index | moved_zero), zero, 0)

    # Spacing of edges, one clock after the position.
    move_before = _clock_before(last_move)
    spacing = np.minimum(clocks - move_before, SPACING_MAX)
    spacing = np.where(move_before > last_reset, spacing, SPACING_MAX)
    too_near = moves & (spacing < column["minimum_edge_spacing"])

    illegal, illegal_count = _sticky(_was(seen.illegal) & ~reset, clear, reset)
    edges_lost = _edges_lost((levels[0], levels[1]), column["filter_length"], seen, filter_reset)
    too_fast = _was((too_near | edges_lost) & ~reset) & ~reset
    overspeed, overspeed_count = _sticky(too_fast, clear, reset)
    swallowed, _ = _sticky(_was(edges_lost & ~reset) & ~reset, clear, reset)
    told = _was(misplaced & ~reset) | (slip != 0)
    index_error, index_error_count = _sticky(told & ~reset, clear, reset)

    # The levels of the clock in which the position was decided.
    place = 2 * b + (a ^ b)
    place = np.where(preload, place, _earlier(place))
    phase_of_zero = np.where(reset | preload, 0, _earlier((place - from_reset) % 4))

    direction = np.where(last_reset == clocks, 1, _earlier(seen.up.astype(np.int64)))
    direction[0] = 1
    after = {
        "position": _wrapped(from_reset),
        "angle": from_zero % turn_in_force,
        "turn_position": _wrapped(from_zero),
        "phase_of_zero": phase_of_zero,
        "direction": direction,
        "step": moves,
        "step_up": moved > 0,
        "index_seen": index_number > 0,
        "index_strobe": strobe,
        "index_position": np.where(index_valid, value_at(last_strobe, latched, 0), 0),
        "index_direction": np.where(
            index_valid, value_at(last_strobe, _earlier(index_up.astype(np.int64)), 1), 1
        ),
        "index_interval": np.where(
            last_strobe > last_forgotten, value_at(last_strobe, interval, 0), 0
        ),
        "index_trusted": trusted,
        "zero_moved": zero_moves % 2,
        "zero_moves": zero_moves % 2**16,
        "zero_slip": np.where(last_slip > last_reset, value_at(last_slip, slip, 0), 0),
        "put_back": _wrapped(healed_total - value_at(last_reset, healed_total, 0)),
        "index_error": index_error,
        "index_error_count": index_error_count,
        "illegal": illegal,
        "illegal_count": illegal_count,
        "overspeed": overspeed,
        "overspeed_count": overspeed_count,
        "swallowed": swallowed,
    }
    power_up = {"direction": 1, "index_direction": 1}
    trace = {
        name: np.concatenate([[power_up.get(name, 0)], values]).astype(np.int64)
        for name, values in after.items()
    }
    edge_time = np.concatenate([np.zeros(1, dtype=np.uint64), last_edge_time])
    return DecoderTrace(last_edge_time=edge_time, **trace)
