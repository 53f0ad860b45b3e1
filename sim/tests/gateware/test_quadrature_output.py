"""The quadrature output model against what a receiver of its edges would see."""

import numpy as np
import pytest
from tb.quadrature_output.quadrature_output_scenarios import SCENARIOS, Scenario, stimuli

from arctrue.gateware.quadrature_output import (
    LATENCY,
    SATURATION,
    OutputInputs,
    OutputTrace,
    quadrature_output,
)


def played(scenario: Scenario) -> tuple[dict[str, np.ndarray], OutputTrace]:
    columns = stimuli(scenario)
    return columns, quadrature_output(OutputInputs(**columns))


def decoded(trace: OutputTrace) -> np.ndarray:
    """Counts that a receiver has counted in each clock; A leads B upwards. Checks every transition.

    The state's place in 00, 10, 11, 01 is the count modulo 4, by the paper's rule.
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
    # The spacing in force when the edge was decided, three clocks before it shows.
    spacing = np.maximum(columns["minimum_spacing"], 1)[at[:-1] - 3]
    assert (np.diff(at) >= spacing).all()


def turned(columns: dict[str, np.ndarray]) -> np.ndarray:
    """The position without its wrap, from 0."""
    moves = np.diff(columns["corrected_position"])
    return np.concatenate([[0], np.cumsum((moves + 2**31) % 2**32 - 2**31)])


def always_enabled(name: str) -> bool:
    return all(g.enable and not g.reset for g in SCENARIOS[name].segments)


@pytest.mark.parametrize("name", [n for n in SCENARIOS if SCENARIOS[n].keeps_up])
def test_output_is_the_position_six_clocks_ago_within_one_count(name: str) -> None:
    columns, trace = played(SCENARIOS[name])
    shown = decoded(trace)[LATENCY:]
    position = turned(columns)[: len(shown)]
    behind = position - shown
    assert np.abs(behind).max() <= 1
    if (columns["minimum_spacing"] > 1).any():
        return
    # Two counts the same way and a clock of rest: nothing is held back.
    last_way = 0
    for clock, move in enumerate(np.diff(position), start=1):
        if move == 0 and last_way in (-2, 2):
            assert behind[clock] == 0
        elif move:
            last_way = int(move) * (2 if last_way * move > 0 else 1)


@pytest.mark.parametrize("name", [n for n in SCENARIOS if always_enabled(n) and n != "saturates"])
def test_following_error_is_what_the_pins_lack_of_the_position_two_clocks_ago(name: str) -> None:
    columns, trace = played(SCENARIOS[name])
    shown = decoded(trace)[2:]
    assert trace.following_error[2:].tolist() == (turned(columns)[: len(shown)] - shown).tolist()


@pytest.mark.parametrize("name", [n for n in SCENARIOS if always_enabled(n) and n != "saturates"])
def test_z_is_high_exactly_at_the_zero_of_the_output_angle(name: str) -> None:
    scenario = SCENARIOS[name]
    columns, trace = played(scenario)
    # The pins, the angle and the position of two clocks ago make one output angle.
    shown = decoded(trace)[2:]
    behind = turned(columns)[: len(shown)] - shown
    angle = (columns["corrected_angle"][: len(shown)] - behind) % scenario.counts_per_rev
    expected = (angle == 0) & (behind >= -2 * scenario.counts_per_rev)
    expected &= behind < 2 * scenario.counts_per_rev
    expected &= columns["referenced"][: len(shown)] == 1
    # The first clock enabled after the reset is not shown yet.
    assert trace.z[3:].tolist() == expected[1:].astype(int).tolist()
    assert expected.any() or scenario.counts_per_rev >= 1000


@pytest.mark.parametrize("turn", [4, 5, 37, 1000])
@pytest.mark.parametrize("down", [False, True])
def test_z_comes_once_a_turn_together_with_an_edge(turn: int, down: bool) -> None:
    # No reference to the position: a receiver counts exactly one turn from Z to Z.
    position = np.arange(20 * turn) // 3 * (-1 if down else 1)
    trace = quadrature_output(OutputInputs(position, position % turn, turn))
    shown = decoded(trace)
    changes = np.flatnonzero(np.diff(trace.z))[1:]
    assert (np.diff(shown)[changes] == (-1 if down else 1)).all()
    rising = changes[trace.z[changes + 1] == 1]
    assert len(rising) >= 5
    assert (np.abs(np.diff(shown[rising + 1])) == turn).all()
    # Both directions meet the same physical edge: up it rises into 0, down it falls out of 0.
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
    # Edges that were on their way when enable fell: within the three clocks that the entity tells.
    recent = np.array([enable[max(0, t - 3) : t + 1].any() for t in range(len(enable))])
    assert recent[at].all()
    for start in np.flatnonzero(np.diff(enable.astype(int)) == 1):
        moved = columns["corrected_position"][start + 1 : start + 12]
        until = decoded(trace)[start + 12] - decoded(trace)[start + 3]
        assert abs(until) <= abs(moved[-1] - moved[0]) + 1


def test_output_forgets_its_lag_when_disabled() -> None:
    _, trace = played(SCENARIOS["enable_while_far_behind"])
    # Behind by almost a thousand before the seven disabled clocks, not an edge after them.
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
    # Cleared in clock 110, when the output has caught up; 9 is allowed, -10 is not.
    assert not flag[111:190].any()
    assert flag[-1]


def test_clear_does_not_hide_a_lasting_lag() -> None:
    _, trace = played(SCENARIOS["too_fast_then_standing"])
    flag = trace.cannot_keep_up
    assert flag[600]
    assert flag[601:2200].all()
    assert not flag[2202:2300].any()


def test_lag_of_two_turns_counts_as_not_keeping_up() -> None:
    _, trace = played(SCENARIOS["limit_beyond_two_turns"])
    assert not trace.cannot_keep_up[:160].any()
    assert trace.cannot_keep_up[165]


def test_following_error_saturates() -> None:
    _, trace = played(SCENARIOS["saturates"])
    assert trace.following_error.max() == SATURATION
    assert trace.following_error.min() == -SATURATION


def test_flag_stays_through_disable() -> None:
    position = np.where(np.arange(200) < 20, 0, 500)
    enable = np.arange(200) < 100
    trace = quadrature_output(
        OutputInputs(position, position, 1000, following_limit=5, enable=enable, minimum_spacing=9)
    )
    assert trace.cannot_keep_up[25:].all()
    assert (trace.following_error[102:] == 0).all()
