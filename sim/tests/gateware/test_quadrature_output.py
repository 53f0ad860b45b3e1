"""Tests the quadrature output's model with a receiver that counts the edges of the output."""

import itertools

import numpy as np
import pytest
from sim.tests.gateware.quadrature_output_scenarios import SCENARIOS, Scenario, stimuli

from arctrue.gateware.error_compensation import error_compensation
from arctrue.gateware.quadrature_output import (
    LATENCY,
    OutputInputs,
    OutputTrace,
    quadrature_output,
)
from arctrue.generated import number_formats

STARTED = 60
"""Number of clocks after which the output has reached the levels of the position."""


def played(scenario: Scenario) -> tuple[dict[str, np.ndarray], OutputTrace]:
    columns = stimuli(scenario)
    return columns, quadrature_output(OutputInputs(**columns))


def decoded(trace: OutputTrace) -> np.ndarray:
    """Return the count of a receiver in each clock; check that no transition is illegal.

    By the paper's figure 4, A leads B upwards: the index of (A, B) in 00, 10, 11, 01 is the count
    modulo 4.
    """
    place = np.array([0, 3, 1, 2])[2 * trace.a + trace.b]
    steps = np.diff(place) % 4
    assert not (steps == 2).any(), "A and B changed together"
    return np.concatenate([[0], np.cumsum((steps + 1) % 4 - 1)])


def edges(trace: OutputTrace) -> np.ndarray:
    return np.flatnonzero(np.diff(decoded(trace)))


def without_reset(names: dict[str, Scenario]) -> list[str]:
    return [name for name, s in names.items() if not any(g.reset for g in s.segments)]


@pytest.mark.parametrize("name", without_reset(SCENARIOS))
def test_edges_are_legal_and_spaced(name: str) -> None:
    columns, trace = played(SCENARIOS[name])
    at = edges(trace)
    # The output decides on an edge three clocks before the edge, with the minimum spacing of that
    # clock.
    spacing = np.maximum(columns["minimum_spacing"], 1)[at[:-1] - 3]
    assert (np.diff(at) >= spacing).all()


def turned(columns: dict[str, np.ndarray]) -> np.ndarray:
    """Return the position without its wrap, in counts from the first position."""
    moves = np.diff(columns["corrected_position"])
    return np.concatenate([[0], np.cumsum((moves + 2**31) % 2**32 - 2**31)])


def turned_from(columns: dict[str, np.ndarray], trace: OutputTrace) -> int:
    """Return the position to which the pins' levels after power-up belong, in counts from the first
    position."""
    to_phase = -columns["phase_of_zero"][0] - columns["corrected_position"][0]
    return int((to_phase + 2) % 4 - 2)


def always_enabled(name: str) -> bool:
    return all(g.enable and not g.reset for g in SCENARIOS[name].segments)


@pytest.mark.parametrize("name", [n for n in SCENARIOS if SCENARIOS[n].keeps_up])
def test_output_is_the_position_six_clocks_ago_within_one_count(name: str) -> None:
    columns, trace = played(SCENARIOS[name])
    shown = decoded(trace)[LATENCY:] + turned_from(columns, trace)
    position = turned(columns)[: len(shown)]
    behind = position - shown
    # At the start at most two edges lead to the levels of the position.
    assert np.abs(behind[:STARTED]).max() <= 3
    assert np.abs(behind[STARTED:]).max() <= 1
    if (columns["minimum_spacing"] > 1).any():
        return
    # After two counts in the same direction and a clock without motion the output must not lag.
    last_way = 0
    for clock, move in enumerate(np.diff(position), start=1):
        if move == 0 and last_way in (-2, 2) and clock > STARTED:
            assert behind[clock] == 0
        elif move:
            last_way = int(move) * (2 if last_way * move > 0 else 1)


def never_stops(name: str) -> bool:
    """Tell whether the output is enabled throughout the scenario and never has a fault."""
    return always_enabled(name) and not played(SCENARIOS[name])[1].cannot_keep_up.any()


@pytest.mark.parametrize("name", [n for n in SCENARIOS if never_stops(n)])
def test_following_error_is_what_the_pins_lack_of_the_position_two_clocks_ago(name: str) -> None:
    columns, trace = played(SCENARIOS[name])
    shown = decoded(trace)[2:] + turned_from(columns, trace)
    behind = turned(columns)[: len(shown)] - shown
    assert trace.following_error[4:].tolist() == behind[2:].tolist()


def settings_of(name: str) -> tuple[bool, int, int]:
    """Return z_gated, z_state and the width of Z in counts; fail if they change within the
    scenario."""
    (found,) = {(g.z_gated, g.z_state, g.z_width) for g in SCENARIOS[name].segments}
    return found[0], found[1], (1, 2, 4)[found[2]]


@pytest.mark.parametrize("name", [n for n in SCENARIOS if never_stops(n)])
def test_z_is_high_exactly_at_the_zero_of_the_output_angle(name: str) -> None:
    scenario = SCENARIOS[name]
    columns, trace = played(scenario)
    gated, state, width = settings_of(name)
    # Element t + 1 of the outputs follows the inputs of clock t. Z follows the angle three clocks
    # later, in element t + 4.
    shown = decoded(trace)[4:] + turned_from(columns, trace)
    turn = scenario.counts_per_rev
    zero = (turned(columns) - columns["corrected_angle"])[: len(shown)][:-1]
    shown = shown[: len(zero)]
    place = np.array([0, 3, 1, 2])[2 * trace.a + trace.b][4:][: len(zero)]
    expected = np.zeros(len(zero), dtype=bool)
    for first in range(-2, 2) if gated else [0]:
        behind = (shown - zero - first) % turn
        expected |= (behind < width) & (((place - behind) % 4 == state) | (not gated))
    expected &= columns["referenced"][: len(zero)] == 1
    assert trace.z[4:][: len(zero)].tolist() == expected.astype(int).tolist()
    assert expected.any() or turn >= 1000


@pytest.mark.parametrize("start", range(-6, 6))
@pytest.mark.parametrize("way", [-1, 1])
@pytest.mark.parametrize("of_zero", range(4))
def test_the_zero_lies_in_one_state_whatever_the_start(start: int, way: int, of_zero: int) -> None:
    """Z is high in the state of A and B that the head has at its index, at whatever count the
    output starts."""
    position = start + way * (np.arange(2000) // 3)
    enable = np.arange(2000) > 40  # the table has moved before
    trace = quadrature_output(
        OutputInputs(position, position % 40, 40, enable=enable, phase_of_zero=of_zero)
    )
    place = np.array([0, 3, 1, 2])[2 * trace.a + trace.b]
    assert set(place[trace.z == 1].tolist()) == {of_zero}


@pytest.mark.parametrize("state", range(4))
def test_gated_z_lies_in_the_state_that_was_asked_for(state: int) -> None:
    position = np.arange(4000) // 3
    for of_zero, width in itertools.product(range(4), range(3)):
        trace = quadrature_output(
            OutputInputs(
                position,
                position % 40,
                40,
                phase_of_zero=of_zero,
                z_gated=True,
                z_state=state,
                z_width=width,
            )
        )
        counts, place = decoded(trace), np.array([0, 3, 1, 2])[2 * trace.a + trace.b]
        rises = np.flatnonzero(np.diff(trace.z) == 1)[1:] + 1
        falls = np.flatnonzero(np.diff(trace.z) == -1)[1:] + 1
        assert len(rises) >= 30
        assert set(place[rises].tolist()) == {state}
        assert set((counts[falls] - counts[rises[: len(falls)]]).tolist()) == {(1, 2, 4)[width]}
        assert set(np.diff(counts[rises]).tolist()) == {40}


def test_a_reset_moves_neither_a_nor_b() -> None:
    clock = np.arange(300)
    position = clock // 3
    held = set()
    for at in range(100, 112):
        reset, enable = (clock >= at) & (clock < at + 64), clock < at
        trace = quadrature_output(
            OutputInputs(position, position % 40, 40, reset=reset, enable=enable)
        )
        # One more edge may come out of the pipeline; after that no edge comes until the output is
        # enabled again.
        assert edges(trace)[-1] <= at + 2
        held.add((int(trace.a[-1]), int(trace.b[-1])))
    assert len(held) == 4


@pytest.mark.parametrize("held", range(4))
def test_a_and_b_keep_their_levels_in_a_reset_from_its_first_clock_on(held: int) -> None:
    """A and B have the levels from before the reset in every clock of the reset, and make no
    illegal transition after it."""
    clock = np.arange(200)
    trace = quadrature_output(OutputInputs(0, 0, 40, reset=clock < 100), held_phase=held)
    place = np.array([0, 3, 1, 2])[2 * trace.a + trace.b]
    assert set(place[:100].tolist()) == {held}
    # The position 0 has the levels 00, at most two counts from the held levels. One count may
    # remain, because the output has a hysteresis.
    assert np.abs(decoded(trace)).max() <= 2
    assert place[-1] in (0, 1)


def test_what_was_missed_is_not_replayed() -> None:
    columns, trace = played(SCENARIOS["backlog_before_a_standstill"])
    stands_from = 20 + 8000
    assert trace.cannot_keep_up[stands_from]
    at = edges(trace)
    fault = int(np.argmax(trace.cannot_keep_up))
    # The limit is 100 counts, and the lag grows by six counts in every ten.
    assert fault < 20 + 4 * (100 / 0.6 + 10)
    assert not ((at > fault + 5) & (at < stands_from + 3000)).any()
    # The clear comes while the table stands: at most two edges lead to the levels of the present
    # position.
    assert ((at > fault + 5) & (at < stands_from + 3060)).sum() <= 2
    resumed = decoded(trace)[stands_from + 3080 :]
    position = turned(columns)[stands_from + 3080 - LATENCY :][: len(resumed)]
    assert np.ptp(position - resumed) <= 1


@pytest.mark.parametrize("turn", [4, 5, 37, 1000])
@pytest.mark.parametrize("down", [False, True])
def test_z_comes_once_a_turn_together_with_an_edge(turn: int, down: bool) -> None:
    # A receiver must count exactly one turn from Z to Z, and Z must change with an edge of A or B.
    position = np.arange(20 * turn) // 3 * (-1 if down else 1)
    trace = quadrature_output(OutputInputs(position, position % turn, turn))
    shown = decoded(trace)
    changes = np.flatnonzero(np.diff(trace.z))[1:]
    assert (np.diff(shown)[changes] == (-1 if down else 1)).all()
    rising = changes[trace.z[changes + 1] == 1]
    assert len(rising) >= 5
    assert (np.abs(np.diff(shown[rising + 1])) == turn).all()
    # Z changes at the same physical edge in both directions: upwards Z rises at the step to 0,
    # downwards Z falls at the step from 0.
    assert (shown[rising + 1] % turn == 0).all()


def test_trembling_gives_no_edges() -> None:
    _, trace = played(SCENARIOS["trembling_between_neighbours"])
    trembling = slice(40 + LATENCY + 4, 940)
    at = edges(trace)
    assert not ((at >= trembling.start) & (at < trembling.stop)).any()


def test_no_edge_at_enable_and_none_while_disabled() -> None:
    columns, trace = played(SCENARIOS["enable_without_burst"])
    enable = columns["enable"].astype(bool)
    at = edges(trace)
    # Edges that are in the pipeline when `enable` falls come within three clocks, as the header
    # states.
    recent = np.array([enable[max(0, t - 3) : t + 1].any() for t in range(len(enable))])
    assert recent[at].all()
    for start in np.flatnonzero(np.diff(enable.astype(int)) == 1):
        moved = columns["corrected_position"][start + 1 : start + 12]
        until = decoded(trace)[start + 12] - decoded(trace)[start + 3]
        assert abs(until) <= abs(moved[-1] - moved[0]) + 1


def test_output_forgets_its_lag_when_disabled() -> None:
    _, trace = played(SCENARIOS["enable_while_far_behind"])
    # Before the seven clocks without `enable` the output lags by almost a thousand counts; after
    # them it makes no edge.
    assert trace.following_error[79] > 900
    assert (trace.following_error[83:87] == 0).all()
    at = edges(trace)
    assert ((at > 60) & (at < 80)).any()
    assert not ((at > 84) & (at < 147)).any()


def test_cannot_keep_up_is_set_beyond_the_limit_and_stays() -> None:
    _, trace = played(SCENARIOS["limit_is_exact"])
    flag = trace.cannot_keep_up
    assert not flag[:70].any()
    assert flag[75:110].all()
    # The clear in clock 110 resets the flag. A lag of -9 counts is permitted; a lag of -10 counts
    # sets the flag.
    assert not flag[111:190].any()
    assert flag[-1]


def test_lag_of_two_turns_counts_as_not_keeping_up() -> None:
    _, trace = played(SCENARIOS["limit_beyond_two_turns"])
    assert not trace.cannot_keep_up[:160].any()
    assert trace.cannot_keep_up[165]


def test_flag_stays_through_disable() -> None:
    position = np.where(np.arange(200) < 20, 0, 500)
    enable = np.arange(200) < 100
    trace = quadrature_output(
        OutputInputs(position, position, 1000, following_limit=5, enable=enable, minimum_spacing=9)
    )
    assert trace.cannot_keep_up[25:].all()
    assert (trace.following_error[102:] == 0).all()


@pytest.mark.parametrize("fold", [1, 2, 4, 8])
@pytest.mark.parametrize("clocks_a_count", [11.0, 17.3, 71.5])
def test_jitter_of_a_folded_pipeline(fold: int, clocks_a_count: float) -> None:
    """A folded pipeline holds each reading for FOLD clocks, so each edge of the output comes 0 to
    FOLD - 1 clocks late."""
    clock = np.arange(20_000)
    position = np.floor(clock / clocks_a_count).astype(np.int64)
    at = edges(quadrature_output(OutputInputs(position[clock // fold * fold], 0, 2**24)))[4:]
    ideal = np.ceil(np.arange(len(at)) * clocks_a_count)
    late = at - at[0] - ideal
    assert np.ptp(late) <= fold - 1 + (clocks_a_count % 1 > 0)
    if fold > 1:
        assert set((np.diff(at) % fold).tolist()) == {0}
        assert np.ptp(np.diff(at)) == fold
    if (fold, clocks_a_count) == (8, 11.0):
        assert set(np.diff(at).tolist()) == {8, 16}


PIPELINE = number_formats.PIPELINE_LATENCY
HEAL_AT = 300


def place_after_a_heal(start: int, phase_late_clocks: int = 0) -> int:
    """Return the output's state of (A, B) minus the head's, modulo 4, after 2 counts were put back.

    Head 1 has lost 2 counts by an illegal transition, so its levels are 2 states ahead of its
    count. The output is enabled in clock ``start``. The counts are put back in clock HEAL_AT and
    reach the output by the ramp. The states are compared long after that.
    """
    clocks, turn = 3000, 1000
    clock = np.arange(clocks)
    reading, lost_places = 100 + np.minimum(clock, 2000) // 40, 2
    moved = clock >= HEAL_AT
    put_back = 2 * moved.astype(np.int64)
    zeros = np.zeros(clocks, dtype=np.int64)
    corrected = error_compensation(
        zeros[:, np.newaxis],
        0,
        reading,
        reading + put_back,
        zeros > 0,
        zeros > 0,
        turn,
        2**28,
        zero_moved=moved,
        put_back=put_back,
    )

    def delayed(values: np.ndarray, by: int) -> np.ndarray:
        return np.concatenate([np.full(by, values[0]), values])[:clocks]

    trace = quadrature_output(
        OutputInputs(
            corrected_position=delayed(corrected.corrected_position, PIPELINE),
            corrected_angle=delayed(corrected.corrected_angle, PIPELINE),
            counts_per_rev=turn,
            phase_of_zero=delayed((lost_places - put_back) % 4, phase_late_clocks),
            enable=clock >= start,
        )
    )
    place = np.array([0, 3, 1, 2])[2 * trace.a[-1] + trace.b[-1]]
    return int((place - reading[-1] - lost_places) % 4)


def test_an_output_that_starts_during_a_heal_has_the_levels_of_the_head_in_the_end() -> None:
    """The output finally has the levels of the head even if it starts while counts that were put
    back are still in the pipeline."""
    starts = range(HEAL_AT + 1, HEAL_AT + PIPELINE + 40)
    assert {place_after_a_heal(start) for start in starts} == {0}
    # If `phase_of_zero` were delayed like the position, the output would keep the old phase for
    # ever.
    assert place_after_a_heal(HEAL_AT + 5, phase_late_clocks=PIPELINE) == 2
