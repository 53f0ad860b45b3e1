"""Compares the decoder's model with the true position of the disc, which the scenarios contain."""

import itertools
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from sim.tests.gateware.quadrature_decoder_scenarios import (
    FAULTY,
    LOSSLESS,
    RANDOM_SEEDS,
    SCATTERED,
    UNITS,
    Scenario,
    Stimuli,
    skewed,
    stimuli,
    stimuli_of,
)

from arctrue.gateware.quadrature_decoder import (
    DecoderInputs,
    DecoderTrace,
    latency_clocks,
    quadrature_decoder,
)
from arctrue.generated.number_formats import COUNTS_PER_PERIOD, FAULT_COUNT_MAX, INDEX_SKEW


def played(name: str) -> tuple[Scenario, Stimuli, DecoderTrace]:
    given = stimuli(name)
    trace = quadrature_decoder(DecoderInputs(**given.columns, timestamp=given.timestamp))
    return (LOSSLESS | SCATTERED | FAULTY)[name], given, trace


def latency(given: Stimuli) -> int:
    """Return the number of clocks from the pins to the position, for a scenario with a single
    filter length."""
    return latency_clocks(int(given.columns["filter_length"][-1]))


def true_marks(scenario: Scenario, given: Stimuli) -> tuple[np.ndarray, np.ndarray]:
    """Return the clocks in which the disc has just passed an index mark, and the direction of each
    passage (+1 up, -1 down)."""
    index = int(scenario.index_at * UNITS)
    turns = (given.place - index) // (scenario.counts_per_rev * UNITS)
    passed = np.diff(turns)
    clocks = np.flatnonzero(passed) + 1
    return clocks, passed[clocks - 1]


def reported_within(given: Stimuli, marks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the first and the last clock in which the decoder may report each mark: from the mark
    until INDEX_SKEW clocks after its step, or until the next step if that is earlier."""
    steps = np.append(np.flatnonzero(np.diff(given.count)) + 1, 2 * len(given.count))
    step = np.searchsorted(steps, marks)
    settled = np.minimum(steps[step] + INDEX_SKEW, steps[np.minimum(step + 1, len(steps) - 1)])
    return marks + latency(given), settled + latency(given)


@pytest.mark.parametrize("name", LOSSLESS)
def test_position_is_that_of_the_disc(name: str) -> None:
    _, given, trace = played(name)
    delay = latency(given)
    expected = given.count[2:-delay] - given.count[2]
    assert trace.position[2 + delay : -1].tolist() == expected.tolist()
    assert trace.illegal_count[-1] == 0


@pytest.mark.parametrize("name", LOSSLESS)
def test_step_and_direction_are_those_of_the_disc(name: str) -> None:
    _, given, trace = played(name)
    delay = latency(given)
    moved = np.diff(given.count)[2:]
    step = trace.step[3 + delay :][: len(moved)]
    step_up = trace.step_up[3 + delay :][: len(moved)]
    assert (step - 2 * (step - step_up)).tolist() == moved[: len(step)].tolist()
    way = trace.direction[3 + delay :][step == 1]
    assert way.tolist() == step_up[step == 1].tolist()


@pytest.mark.parametrize("name", LOSSLESS)
def test_angle_is_that_of_the_disc_modulo_its_turn(name: str) -> None:
    scenario, given, trace = played(name)
    delay = latency(given)
    turn = scenario.counts_per_rev
    marks, _ = true_marks(scenario, given)
    assert marks.size >= 2, "a scenario without the index tests nothing here"
    # Before the first index the angle counts from the start, after that from the index, which lies
    # at count 0.
    before = (given.count - given.count[2]) % turn
    after = given.count % turn
    seen = int(np.argmax(trace.index_seen))
    earliest, latest = reported_within(given, marks)
    assert earliest[0] <= seen <= latest[0]
    assert trace.index_seen[seen:].all()
    expected = np.where(np.arange(len(after)) < seen - delay, before, after)[2:-delay]
    assert trace.angle[2 + delay : -1].tolist() == expected.tolist()
    # turn_position is the angle without the modulo: its zero stays at the index of one turn of the
    # disc.
    zeros = (given.count[:-delay] - trace.turn_position[delay:-1])[seen - delay :]
    assert len(set(zeros.tolist())) == 1
    assert zeros[0] % turn == 0


@pytest.mark.parametrize("name", LOSSLESS)
def test_index_is_one_place_of_the_disc_in_both_directions(name: str) -> None:
    scenario, given, trace = played(name)
    marks, ways = true_marks(scenario, given)
    at = np.flatnonzero(trace.index_strobe)
    earliest, latest = reported_within(given, marks)
    assert len(at) == (latest + 1 < len(trace.step)).sum()
    assert (at >= earliest[: len(at)] + 1).all()
    assert (at <= latest[: len(at)] + 1).all()
    assert trace.index_direction[at].tolist() == (ways[: len(at)] > 0).astype(int).tolist()
    place = trace.index_position[at] + given.count[2]
    assert (place % scenario.counts_per_rev == 0).all()
    intervals = np.diff(place)
    assert trace.index_interval[at].tolist() == [0, *intervals.tolist()]
    assert set(np.abs(intervals).tolist()) <= {0, scenario.counts_per_rev}
    assert trace.index_error_count[-1] == 0
    assert trace.index_error[-1] == 0


def test_scenarios_meet_the_index_in_every_way() -> None:
    ways, intervals, coincides = set(), set(), set()
    for name in LOSSLESS:
        scenario, given, _ = played(name)
        marks, way = true_marks(scenario, given)
        turns = np.diff(given.count[marks]) // scenario.counts_per_rev
        intervals |= set(np.sign(turns).tolist())
        ways |= set(way.tolist())
        coincides |= set((np.diff(given.count)[marks - 1] != 0).tolist())
    assert ways == {-1, 1}
    assert intervals == {-1, 0, 1}
    assert coincides == {False, True}


@pytest.mark.parametrize("name", LOSSLESS)
def test_time_of_the_last_edge(name: str) -> None:
    _, given, trace = played(name)
    delay = latency(given)
    edges = np.flatnonzero(np.diff(given.count)[2:]) + 3
    edges = edges[edges + delay < len(trace.step)]
    # The time stamp is the time (modulo 2**64) of the clock that comes delay - 1 clocks after the
    # change of the pin.
    expected = given.timestamp[edges] + np.uint64(delay - 1)
    assert (trace.last_edge_time[edges + delay] == expected).all()
    held = trace.last_edge_time[edges[0] + delay :]
    changes = np.flatnonzero(np.diff(held)) + 1
    assert len(changes) == len(edges) - 1


@pytest.mark.parametrize("stages", [2, 3, 4])
@pytest.mark.parametrize("filter_length", [1, 2, 7])
def test_no_edge_after_reset_with_any_levels(filter_length: int, stages: int) -> None:
    # The reset lasts one clock, in which the pins change.
    clock = np.arange(60)
    for before, during, at in itertools.product(range(8), range(8), (0, 20)):
        levels = np.where(clock < at, before, during)
        inputs = DecoderInputs(
            a=levels >> 2,
            b=levels >> 1 & 1,
            z=levels & 1,
            reset=clock == at,
            filter_length=filter_length,
        )
        trace = quadrature_decoder(inputs, stages)
        for output in ("position", "step", "illegal", "index_seen", "index_strobe", "angle"):
            assert not getattr(trace, output)[at + 1 :].any(), (output, before, during)


@pytest.mark.parametrize("stages", [2, 3, 4])
@pytest.mark.parametrize("way", [-1, 1])
def test_every_edge_after_the_last_clock_of_reset_counts(way: int, stages: int) -> None:
    count = np.arange(100) * way
    a, b = np.isin(count % 4, (1, 2)), np.isin(count % 4, (2, 3))
    for resets in (1, 2, 5):
        trace = quadrature_decoder(DecoderInputs(a, b, reset=np.arange(100) < resets), stages)
        delay = latency_clocks(1, stages)
        expected = count[resets - 1 : -delay] - count[resets - 1]
        assert trace.position[resets - 1 + delay : -1].tolist() == expected.tolist()


def test_illegal_transitions_are_reported_and_not_counted() -> None:
    _, given, trace = played("illegal_in_every_clock")
    # The disc jumps by half a period thirteen times, eight of them before the clear.
    assert trace.illegal_count.max() == 8
    assert (trace.position == 0).all()
    assert not trace.step.any()
    cleared = int(np.flatnonzero(given.columns["clear"])[0]) + 1
    # A jump in the clock of the clear is counted after the clear.
    assert trace.illegal_count[cleared - 1 : cleared + 1].tolist() == [8, 1]
    assert trace.illegal_count[-1] == 13 - 8
    assert trace.illegal[cleared:].all()


def test_lost_and_added_counts_show_at_the_next_index() -> None:
    scenario, given, trace = played("lost_count_between_index_marks")
    marks, _ = true_marks(scenario, given)
    intervals = trace.index_interval[np.flatnonzero(trace.index_strobe)]
    # When the disc jumps, the decoder loses counts or adds counts, so two intervals between index
    # marks are wrong.
    wrong = (intervals != 0) & (np.abs(intervals) != scenario.counts_per_rev)
    assert wrong[1:].any()
    assert trace.index_error_count.max() == wrong.sum() == 2
    # The error is reported three clocks after the strobe and stays until the clear.
    strobes = np.flatnonzero(trace.index_strobe)[wrong]
    cleared = int(np.flatnonzero(given.columns["clear"])[-1]) + 1
    assert np.flatnonzero(trace.index_error).tolist() == list(range(strobes[0] + 3, cleared))
    assert not trace.index_error_count[cleared:].any()
    assert not trace.illegal[cleared:].any()
    # Every index mark was reported.
    assert trace.index_strobe.sum() == marks.size


def test_a_lost_period_shows_only_at_the_index() -> None:
    scenario, _, trace = played("a_lost_period_shows_only_at_the_index")
    assert not trace.illegal.any()
    strobes = np.flatnonzero(trace.index_strobe)
    wrong = trace.index_interval[strobes] == scenario.counts_per_rev - 4
    assert wrong.sum() == 1
    assert trace.index_error_count[-1] == 1
    assert trace.index_error[strobes[wrong][0] + 3] == 1
    assert trace.index_error[strobes[wrong][0] + 2] == 0


def marks_of_scattered_index(name: str) -> tuple[Scenario, Stimuli, DecoderTrace, np.ndarray]:
    """Return the scenario, its inputs and outputs, and the true places, in counts, of the marks
    that the disc passes."""
    scenario, given, trace = played(name)
    shifted = given.place - int(scenario.index_at * UNITS) - given.mark_scatter * UNITS
    turns = shifted // (scenario.counts_per_rev * UNITS)
    passed = np.diff(turns)
    clocks = np.flatnonzero(passed) + 1
    places = np.maximum(turns[clocks], turns[clocks - 1]) * scenario.counts_per_rev
    return scenario, given, trace, places + given.mark_scatter[clocks]


@pytest.mark.parametrize("name", SCATTERED)
def test_a_scattered_index_moves_no_count(name: str) -> None:
    scenario, given, trace, places = marks_of_scattered_index(name)
    delay = latency(given)
    at = np.flatnonzero(trace.index_strobe)
    assert (trace.index_position[at] + given.count[2]).tolist() == places[: len(at)].tolist()
    assert len(set((places % scenario.counts_per_rev).tolist())) > 1, "the index does not scatter"
    # The first mark sets the zero to its own place; later marks do not move the zero.
    seen = int(np.argmax(trace.index_seen))
    expected = given.count[seen - delay : -delay] - places[0]
    assert trace.turn_position[seen:-1].tolist() == expected.tolist()
    assert trace.angle[seen:-1].tolist() == (expected % scenario.counts_per_rev).tolist()


@pytest.mark.parametrize("name", SCATTERED)
def test_an_index_within_its_tolerance_is_no_error(name: str) -> None:
    scenario, given, trace, places = marks_of_scattered_index(name)
    at = np.flatnonzero(trace.index_strobe)
    steps = np.abs(np.diff(places[: len(at)]))
    off = np.minimum(steps, np.abs(steps - scenario.counts_per_rev))
    assert off.max() == 2 * scenario.index_scatter
    # The decoder compares the mark with the tolerance in the clock after the strobe.
    tolerance = given.columns["index_tolerance"][at[1:] + 1]
    wrong = off > tolerance
    assert trace.index_error_count[-1] == wrong.sum()
    if name == "tolerance_changes_with_every_clock":
        assert 5 < wrong.sum() < wrong.size - 5
        assert (off == tolerance).any()
        assert (off == tolerance + 1).any()
    else:
        assert not wrong.any()
        strict = given.columns | {"index_tolerance": 2 * scenario.index_scatter - 1}
        reported = quadrature_decoder(DecoderInputs(**strict, timestamp=given.timestamp))
        assert reported.index_error_count[-1] == (off == off.max()).sum() > 0


def test_the_zero_is_found_again_by_two_marks_that_agree() -> None:
    name = "lost_counts_and_the_zero_found_again"
    scenario, given, trace = played(name)
    delay = latency(given)
    turn = scenario.counts_per_rev
    off = (trace.angle[delay:-1] - given.count[:-delay]) % turn
    off = np.where(off > turn // 2, off - turn, off)
    ends = np.cumsum([segment.clocks for segment in scenario.segments]) - delay - 1
    # At the end of each stretch the zero is right again, except in two stretches in which the
    # decoder must not correct it. `index_seen` stays high, so that the correction continues.
    assert off[ends[1:]].tolist() == [0, 0, 0, 0, -12, -12, 0, 0]
    first = int(np.argmax(trace.index_seen))
    assert trace.index_seen[first:].all()
    # The error of the angle is 0 or the number of lost counts, and the angle is right again within
    # two turns after a loss.
    assert set(off[first:].tolist()) <= {0, -4, 8, -12}
    wrong_clocks = np.diff(np.flatnonzero(np.diff(off[first:]) != 0))[::2]
    assert (wrong_clocks[:2] <= 2 * turn * 3 + 20).all()
    # The position still lacks the lost counts.
    assert trace.position[-1] == given.count[-delay] - given.count[2] + (-4 + 8 - 12)
    # The angle equals turn_position modulo the turn in every clock.
    assert (trace.turn_position[first:] % turn == trace.angle[first:]).all()


@pytest.mark.parametrize("false_at", [(130,), (130, 260), (130, 131, 300)])
def test_false_marks_do_not_move_the_zero(false_at: tuple[int, ...]) -> None:
    """False marks do not move the zero, because no two of them are a turn apart."""
    count = np.repeat(np.arange(700), 8)
    mark = (count % 100 == 0) | np.isin(count, false_at)
    clock = np.arange(count.size)
    pins = (np.isin(count % 4, (1, 2)), np.isin(count % 4, (2, 3)), mark)
    trace = quadrature_decoder(
        DecoderInputs(
            *pins, counts_per_rev=100, reset=clock < 3, zero_again=True, index_tolerance=2
        )
    )
    delay = latency_clocks()
    seen = int(np.argmax(trace.index_seen))
    assert trace.index_error_count[-1] >= 2
    assert (trace.angle[seen:-1] == count[seen - delay : -delay] % 100).all()


def test_a_lost_period_is_seen_up_to_a_tolerance_of_3() -> None:
    _, given, trace = played("a_lost_period_within_the_tolerance_of_a_bad_index")
    tolerance = given.columns["index_tolerance"]
    errors = np.maximum(np.diff(trace.index_error_count), 0)
    assert errors[tolerance == 3].sum() == 2
    assert errors[tolerance == 4].sum() == 0
    assert not trace.illegal.any()


def test_overspeed_is_an_edge_nearer_than_the_spacing() -> None:
    scenario, given, trace = played("overspeed")
    delay = latency(given)
    edges = np.flatnonzero(np.diff(given.count)) + 1
    distances = np.diff(edges)
    # The setting of the clock in which the edge is counted applies; the flag follows one clock
    # later.
    counted = edges[1:] + delay - 1
    too_near = distances < given.columns["minimum_edge_spacing"][counted]
    shown = counted[too_near] + 2
    clears = np.flatnonzero(given.columns["clear"]) + 1
    expected = [
        ((shown <= t) & (shown >= max([c for c in clears if c <= t], default=0))).sum()
        for t in range(len(trace.step))
    ]
    assert trace.overspeed_count.tolist() == expected
    assert trace.overspeed.tolist() == [int(count > 0) for count in expected]
    assert {5, 6, 1} <= set(distances[too_near].tolist())
    assert trace.position.max() == given.count[-1] - scenario.start


def test_edges_that_the_filter_swallows_are_reported() -> None:
    _, given, trace = played("faster_than_the_filter")
    too_fast = np.flatnonzero(np.diff(given.count) != 0)
    too_fast = too_fast[too_fast >= 3 + 20 + 180]
    # The decoder must report the overspeed at most five counts after the first count that is too
    # fast, because it detects an overspeed in the levels before the filter.
    reported = int(np.argmax(trace.overspeed))
    assert too_fast[0] < reported <= too_fast[5] + latency_clocks()
    assert not trace.illegal.any()
    cleared = int(np.flatnonzero(given.columns["clear"])[0]) + 1
    assert not trace.overspeed[cleared + 1 : cleared + 20].any()
    assert trace.overspeed[-1]
    # The overspeed count equals the number of lost periods, except possibly for the last period, in
    # which the levels came to rest.
    lost = (
        abs(int(given.count[cleared] - given.count[2] - trace.position[cleared]))
        // COUNTS_PER_PERIOD
    )
    assert lost >= 8
    assert abs(int(trace.overspeed_count[cleared - 1]) - lost) <= 1


def test_order_broken_where_the_filter_shows_nothing_is_reported() -> None:
    _, _, trace = played("two_counts_a_clock_after_the_filter")
    assert not trace.step.any()
    assert not trace.illegal.any()
    assert trace.overspeed[-1]


@pytest.mark.parametrize("name", ["glitches_are_filtered", "long_filter", "jitter"])
def test_what_the_filter_is_for_is_no_overspeed(name: str) -> None:
    _, _, trace = played(name)
    assert not trace.overspeed.any()


@pytest.mark.parametrize("pulse", range(1, 9))
def test_a_pulse_on_one_pin_is_no_overspeed(pulse: int) -> None:
    """A pulse on A is not an overspeed, wherever it lies between the edges of B; counts are twelve
    clocks apart."""
    clock = np.arange(400)
    count = clock // 12
    for at in range(150, 198):
        a, b = np.isin(count % 4, (1, 2)), np.isin(count % 4, (2, 3))
        spoilt = (clock >= at) & (clock < at + pulse)
        edges = np.flatnonzero(np.diff(b) != 0) + 1
        inputs = DecoderInputs(a ^ spoilt, b, filter_length=9, reset=clock < 3)
        trace = quadrature_decoder(inputs)
        # Only a pulse during which B changes (even in its first clock) looks like a period of A and
        # B.
        if not ((edges >= at) & (edges <= at + pulse)).any():
            assert not trace.overspeed.any(), at


def test_spacing_up_to_its_end() -> None:
    _, _, trace = played("edges_65535_clocks_apart")
    # The required spacing is 65,535 clocks; the edges are 65,534, 65,535 and 66,001 clocks apart.
    assert trace.position[-1] == 4
    assert trace.overspeed_count[-1] == 1


def test_glitches_without_filter_count_up_and_down_again() -> None:
    _, given, trace = played("glitches_are_counted_without_filter")
    delay = latency(given)
    moved = np.flatnonzero(np.diff(given.count)[3:])
    assert trace.step.sum() > len(moved)
    assert trace.position[-1] == given.count[-delay] - given.count[2]


def rearmed(name: str) -> tuple[Stimuli, DecoderTrace, np.ndarray]:
    _, given, trace = played(name)
    return given, trace, given.columns["rearm"].astype(bool)


def test_rearm_forgets_the_index_and_starts_the_angle_at_zero() -> None:
    given, trace, rearm = rearmed("rearm_with_new_turns")
    after = np.flatnonzero(rearm) + 1
    for output in ("angle", "turn_position", "index_seen", "index_strobe", "index_interval"):
        assert not getattr(trace, output)[after].any(), output
    # A re-arm never changes the position.
    delay = latency(given)
    expected = given.count[2:-delay] - given.count[2]
    assert trace.position[2 + delay : -1].tolist() == expected.tolist()
    # The counts per turn at a re-arm apply until the next re-arm; a later change of the setting has
    # no effect before that.
    ends = [*after[np.diff(after, append=10**9) > 1], len(rearm) + 1]
    turns = set()
    for start, end in itertools.pairwise(ends):
        turn = int(given.columns["counts_per_rev"][start - 1])
        turns.add(turn)
        stretch = slice(start, end - 1)
        assert (trace.angle[stretch] == trace.turn_position[stretch] % turn).all()
        assert trace.angle[stretch].max() < turn
    assert turns == {40, 9, 2**24, 4}


def test_index_before_a_rearm_is_no_measure_for_the_one_after_it() -> None:
    count = np.arange(400)
    pins = {
        "a": np.isin(count % 4, (1, 2)),
        "b": np.isin(count % 4, (2, 3)),
        # The first mark after the re-arm lies 33 counts after the last mark before it.
        "z": np.isin(count, (100, 133, 183)),
    }
    rearm = count == 120
    inputs = DecoderInputs(**pins, counts_per_rev=50, reset=count < 3, rearm=rearm)
    trace = quadrature_decoder(inputs)
    strobes = np.flatnonzero(trace.index_strobe)
    assert trace.index_interval[strobes].tolist() == [0, 0, 50]
    assert not trace.index_error.any()
    without = quadrature_decoder(
        DecoderInputs(**pins, counts_per_rev=50, reset=count < 3, rearm=False)
    )
    assert without.index_interval[strobes].tolist() == [0, 33, 50]
    assert without.index_error_count[-1] == 1


def test_clear_and_rearm_leave_each_other_alone() -> None:
    name = "random_pins_0"
    given = stimuli(name)
    flags = ("index_error", "illegal", "overspeed", "swallowed")
    quiet = dict.fromkeys(("clear", "rearm"), 0)
    base = quadrature_decoder(DecoderInputs(**(given.columns | quiet), timestamp=given.timestamp))
    clear = quadrature_decoder(
        DecoderInputs(**(given.columns | {"rearm": 0}), timestamp=given.timestamp)
    )
    rearm = quadrature_decoder(
        DecoderInputs(**(given.columns | {"clear": 0}), timestamp=given.timestamp)
    )
    for output in base.__dataclass_fields__:
        if not output.startswith(flags):
            assert (getattr(clear, output) == getattr(base, output)).all(), output
    for output in ("illegal", "illegal_count", "overspeed", "overspeed_count", "position"):
        assert (getattr(rearm, output) == getattr(base, output)).all(), output


def test_z_without_a_step_is_no_index() -> None:
    clock = np.arange(60)
    z = (clock > 20) & (clock < 30)
    still = quadrature_decoder(DecoderInputs(0, 0, z, reset=clock < 3))
    assert not still.index_seen.any()
    stopped = quadrature_decoder(DecoderInputs(clock > 10, 0, z, reset=clock < 3))
    assert not stopped.index_seen.any()
    moved = quadrature_decoder(DecoderInputs(clock > 25, 0, clock > 20, reset=clock < 3))
    assert moved.index_seen[-1] == 1


@pytest.mark.parametrize(
    "width",
    [pytest.param(1, marks=pytest.mark.large), 2, pytest.param(17, marks=pytest.mark.large)],
)
def test_skewed_pins_do_not_move_the_zero(width: int) -> None:
    """With any delays of A, B and Z of up to three clocks, the zero does not move while the disc
    moves to and fro over both edges of a mark."""
    for skew in itertools.product(range(4), repeat=3):
        given = stimuli_of(skewed(skew, width))
        trace = quadrature_decoder(DecoderInputs(**given.columns, timestamp=given.timestamp))
        at = np.flatnonzero(trace.index_strobe)
        places = trace.index_position[at] + given.count[2]
        assert len(at) >= 10
        assert set(places.tolist()) == {0}, skew
        assert (trace.angle[-1] - given.count[-1]) % 1000 == 0
        assert not trace.index_error.any()


def marks_off(clocks_a_count: int, skew: tuple[int, int, int], width: int) -> tuple[int, int]:
    """Return the number of reported marks, and their largest distance, in counts, from the true
    place.

    The disc passes a mark in both directions, and moves to and fro by two and four counts over both
    edges. ``skew`` has the delays of A, B and Z in clocks.
    """
    first, last = 20, 20 + width
    ways = [40, -40, 40, -40]
    for edge in (first, last):
        for size in (1, 2):
            ways += [edge - size + 1, *[2 * size, -2 * size] * 4, -(edge - size + 1)]
    steps = np.concatenate([np.full(abs(way), np.sign(way)) for way in ways])
    count = np.repeat(np.concatenate([[0], np.cumsum(steps), [0] * 5]), clocks_a_count)
    place = np.concatenate([np.zeros(20, int), count])
    pins = (
        np.isin(place % 4, (1, 2)),
        np.isin(place % 4, (2, 3)),
        (place >= first) & (place < last),
    )
    late = [np.roll(pin, by) for pin, by in zip(pins, skew, strict=True)]
    clock = np.arange(place.size)
    trace = quadrature_decoder(DecoderInputs(*late, counts_per_rev=1000, reset=clock < 3))
    reported = trace.index_position[np.flatnonzero(trace.index_strobe)]
    return reported.size, int(np.abs(reported - first).max())


SKEWS = list(itertools.product(range(INDEX_SKEW + 1), repeat=3))
LEAST_CLOCKS_A_COUNT = 2 * INDEX_SKEW + 1


@pytest.mark.parametrize("width", [1, 2, pytest.param(17, marks=pytest.mark.large)])
@pytest.mark.parametrize(
    "most",
    [
        *range(1, INDEX_SKEW),
        pytest.param(INDEX_SKEW, marks=pytest.mark.large),
    ],
)
def test_the_fastest_index_of_skewed_pins(most: int, width: int) -> None:
    """If the pins change up to ``most`` clocks apart, the spacing in the entity's header is the
    smallest one at which every mark is at its place; at a smaller spacing some marks are displaced.

    The spacing results from two facts: the decoder reads Z INDEX_SKEW clocks after a step, and the
    Z of the next step may come ``most`` clocks before that step.
    """
    least = most + INDEX_SKEW + 1
    skews = [skew for skew in SKEWS if max(skew) <= most]
    for clocks in (least, least + 1, least + 4):
        found = [marks_off(clocks, skew, width) for skew in skews]
        assert min(reported for reported, _ in found) > 10
        assert max(off for _, off in found) == 0, clocks
    faster = [marks_off(least - 1, skew, width)[1] for skew in skews]
    assert max(faster) > 0


@pytest.mark.parametrize("clocks", [1, 2, 3, 5])
def test_pins_that_change_together_give_every_index_at_any_speed(clocks: int) -> None:
    assert marks_off(clocks, (0, 0, 0), 17)[1] == 0


@pytest.mark.parametrize("width", [1, 17])
def test_a_mark_within_a_count_needs_that_spacing_on_both_sides(width: int) -> None:
    """If Z changes half a count after its step, half a count must last as long as that spacing: at
    14 clocks per count every mark is at its place, at 12 some marks are displaced."""
    for half_count_clocks, is_kept in (
        (LEAST_CLOCKS_A_COUNT, True),
        (LEAST_CLOCKS_A_COUNT - 1, False),
    ):
        off = 0
        for skew in SKEWS:
            scenario = skewed(skew, width, half_count_clocks=half_count_clocks)
            given = stimuli_of(replace(scenario, index_at=Fraction(1, 2)))
            trace = quadrature_decoder(DecoderInputs(**given.columns, timestamp=given.timestamp))
            at = np.flatnonzero(trace.index_strobe)
            off += int(np.sum(trace.index_position[at] + given.count[2] != 0))
        assert (off == 0) == is_kept


@pytest.mark.parametrize("z_early", [0, 1])
def test_one_count_of_tremble_next_to_the_far_edge_of_a_mark(z_early: int) -> None:
    """The far edge of a mark does not become the zero if the disc moves up through a mark of 6
    counts, then to and fro by one count, and then on."""
    ways = [1] * 10 + [1] * 7 + [-1, 1] * 3 + [1] * 5
    count = np.repeat(np.concatenate([[0], np.cumsum(ways)]), 20)
    mark = np.roll((count >= 10) & (count < 16), -z_early)
    clock = np.arange(count.size)
    pins = (np.isin(count % 4, (1, 2)), np.isin(count % 4, (2, 3)), mark)
    trace = quadrature_decoder(DecoderInputs(*pins, counts_per_rev=1000, reset=clock < 3))
    at = np.flatnonzero(trace.index_strobe)
    assert trace.index_position[at].tolist() == [10]


def test_a_reversal_within_a_count_leaves_no_trace() -> None:
    """A reversal within a count has no effect, even if Z changes in the middle of this count."""
    half_counts = [*range(40), *range(39, 37, -1), *range(39, 60), *range(59, 10, -1)]
    half_counts = np.repeat(half_counts, 12)
    count = half_counts // 2
    # The mark reaches from the middle of count 5 to the middle of count 19.
    mark = (half_counts >= 11) & (half_counts < 39)
    pins = (np.isin(count % 4, (1, 2)), np.isin(count % 4, (2, 3)), mark)
    trace = quadrature_decoder(
        DecoderInputs(*pins, counts_per_rev=1000, reset=np.arange(count.size) < 3)
    )
    at = np.flatnonzero(trace.index_strobe)
    assert trace.index_position[at].tolist() == [5]


def test_position_wraps_and_its_readers_do_not() -> None:
    given = stimuli("edge_every_clock_turn_of_7")
    inputs = DecoderInputs(**given.columns)
    plain = quadrature_decoder(inputs)
    wrapping = quadrature_decoder(inputs, reset_position=2**31 - 20)
    assert np.abs(np.diff(wrapping.position)).max() == 2**32 - 1
    for output in ("angle", "turn_position", "index_interval", "index_error"):
        assert (getattr(wrapping, output) == getattr(plain, output)).all(), output
    # The steps of the position, modulo 2**32, equal those without a wrap.
    differences = (np.diff(wrapping.position) + 2**31) % 2**32 - 2**31
    assert differences[4:].tolist() == np.diff(plain.position)[4:].tolist()


def test_counters_stop_at_their_end() -> None:
    clock = np.arange(FAULT_COUNT_MAX + 100)
    both = clock % 2
    trace = quadrature_decoder(DecoderInputs(both, both, reset=clock < 3))
    assert trace.illegal_count[-1] == FAULT_COUNT_MAX
    assert trace.illegal_count[FAULT_COUNT_MAX // 2] == FAULT_COUNT_MAX // 2 - 2 - latency_clocks()


@pytest.mark.parametrize("name", RANDOM_SEEDS)
def test_random_pins_meet_every_fault(name: str) -> None:
    given = stimuli(name)
    trace = quadrature_decoder(DecoderInputs(**given.columns, timestamp=given.timestamp))
    for output in ("illegal", "index_error", "overspeed", "index_strobe"):
        assert getattr(trace, output).any(), output


@pytest.mark.parametrize("turn", [0, 3, 2**24 + 1])
def test_illegal_turns_are_refused(turn: int) -> None:
    with pytest.raises(ValueError, match="counts_per_rev is"):
        quadrature_decoder(DecoderInputs(np.zeros(10), np.zeros(10), counts_per_rev=turn))


def test_inputs_without_a_clock_are_refused() -> None:
    with pytest.raises(ValueError, match="no clock"):
        quadrature_decoder(DecoderInputs([], []))
