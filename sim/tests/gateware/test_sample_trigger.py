"""Tests that the trigger's model follows its definition for equal times and equal angles."""

import numpy as np
import pytest

from arctrue.gateware.sample_trigger import sample_trigger, wrapped

SETTLED = 40
"""Number of clocks after which the trigger knows the multiples of the angle step (the grid); the
entity's header states 38."""


def sampled(trigger: np.ndarray) -> list[int]:
    return np.flatnonzero(trigger).tolist()


@pytest.mark.parametrize("period", [1, 2, 3, 10, 97])
def test_equal_time_is_every_period(period: int) -> None:
    assert sampled(sample_trigger(np.zeros(1000, int), sample_period=period)) == list(
        range(period - 1, 1000, period)
    )


def test_period_0_acts_as_1() -> None:
    assert sample_trigger(np.zeros(50, int), sample_period=0).all()


def test_paper_rate_is_1_khz() -> None:
    assert sampled(sample_trigger(np.zeros(300_000, int))) == [99_999, 199_999, 299_999]


def test_changed_period_holds_for_the_interval_under_way() -> None:
    longer = np.where(np.arange(80) < 35, 10, 20)
    assert sampled(sample_trigger(np.zeros(80, int), sample_period=longer)) == [9, 19, 29, 49, 69]
    shorter = np.where(np.arange(48) < 35, 10, 4)
    assert sampled(sample_trigger(np.zeros(48, int), sample_period=shorter)) == [
        *(9, 19, 29),
        *(35, 39, 43, 47),
    ]


def test_enable_restarts_the_interval() -> None:
    enable = np.ones(40, bool)
    enable[15] = False
    assert sampled(sample_trigger(np.zeros(40, int), enable=enable, sample_period=10)) == [
        9,
        25,
        35,
    ]


def walk(seed: int, clocks: int, start: int) -> np.ndarray:
    """Return positions that move by at most one count per clock, mostly in one direction for 50
    clocks."""
    random = np.random.default_rng(seed)
    drift = np.repeat(random.choice([-1, 0, 1], clocks // 50 + 1), 50)[:clocks]
    moves = np.where(random.random(clocks) < 0.3, random.integers(-1, 2, clocks), drift)
    moves[:SETTLED] = 0
    return start + np.cumsum(moves)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("step", [1, 2, 3, 7, 31])
def test_equal_angle_is_the_next_multiple_in_either_direction(seed: int, step: int) -> None:
    # The test applies the definition: a sample comes at each multiple of the step that is not the
    # multiple reached before.
    start = int(np.random.default_rng(seed).integers(-(2**30), 2**30))
    position = walk(seed, 3000, start)
    clocks = sampled(sample_trigger(position, mode=1, angle_step=step))
    on_grid = position % step == 0
    reached = position[0] if on_grid[0] else None
    expected = []
    for clock in range(1, len(position)):
        if on_grid[clock] and position[clock] != reached:
            reached = position[clock]
            expected.append(clock)
    assert clocks == expected
    assert len(clocks) > 3
    assert set(np.abs(np.diff(position[clocks]))) <= {step}


@pytest.mark.parametrize("step", [1, 5, 1398])
def test_equal_angle_samples_the_same_counts_in_both_directions(step: int) -> None:
    up = np.concatenate([np.full(SETTLED, -3), np.arange(-3, 20_000)])
    down = np.concatenate([np.full(SETTLED, 20_003), np.arange(20_003, 0, -1)])
    inside = range(step, 20_000 - step)
    seen = [
        {p for p in motion[sample_trigger(motion, mode=1, angle_step=step)].tolist() if p in inside}
        for motion in (up, down)
    ]
    assert seen[0] == seen[1] == {p for p in inside if p % step == 0}


def test_trembling_on_a_step_gives_one_sample() -> None:
    position = np.concatenate([np.full(SETTLED, 95), np.arange(95, 101), [99, 100, 101, 100] * 200])
    assert sample_trigger(position, mode=1, angle_step=10).sum() == 1


def test_grid_is_found_while_the_table_turns_with_an_edge_every_clock() -> None:
    position = np.arange(-5_000, 5_000)
    reached = position[sample_trigger(position, mode=1, angle_step=7)]
    assert reached[0] <= -5_000 + 60
    assert (reached % 7 == 0).all()
    assert (np.diff(reached) == 7).all()


def test_grid_is_found_in_the_clocks_that_the_entity_promises() -> None:
    # Every count is a multiple of the step, and the table moves by one count in every clock, so
    # only the search for the grid delays the trigger.
    position = np.arange(200)
    enable = position >= 20
    assert sampled(sample_trigger(position, enable=enable, mode=1, angle_step=1))[0] == 20 + 36
    step = np.where(position < 100, 3, 1)
    clocks = sampled(sample_trigger(position, mode=1, angle_step=step))
    assert min(clock for clock in clocks if clock >= 100) == 100 + 38


@pytest.mark.parametrize("slip", [-4, 4, 1, 2, 3, -7, 1 << 20])
@pytest.mark.parametrize("clocks_a_count", [1, 3])
def test_after_a_zero_move_the_grid_is_that_of_the_new_zero(slip: int, clocks_a_count: int) -> None:
    """No trigger comes in the clock in which the zero moves and in the 38 clocks after it; then a
    trigger comes at every multiple from the new zero."""
    clock = np.arange(6000)
    moves = 3001
    position = 5 + clock // clocks_a_count + slip * (clock >= moves)
    trigger = sample_trigger(position, mode=1, angle_step=16, zero_moved=clock >= moves)
    assert (position[trigger] % 16 == 0).all()
    assert not trigger[moves : moves + 39].any()
    settled = clock >= moves + SETTLED
    reached = np.flatnonzero(settled & (position % 16 == 0) & (np.diff(position, prepend=0) != 0))
    assert sampled(trigger & settled) == reached.tolist()
    assert reached.size > 50


def test_a_jump_that_no_decoder_makes_is_refused() -> None:
    with pytest.raises(ValueError, match="moves by 2 counts"):
        sample_trigger(2 * np.arange(50), mode=1, angle_step=8)


def test_grid_goes_on_evenly_across_the_wrap() -> None:
    position = np.concatenate([np.full(SETTLED, 2**31 - 500), np.arange(2**31 - 500, 2**31 + 500)])
    folded = np.array([wrapped(int(p)) for p in position])
    reached = position[sample_trigger(folded, mode=1, angle_step=12)]
    assert (reached % 12 == 0).all()
    assert len(reached) == 83
    assert (np.diff(reached) == 12).all()


def test_step_0_and_no_enable_give_no_sample() -> None:
    position = np.arange(500)
    assert not sample_trigger(position, mode=1, angle_step=0).any()
    assert not sample_trigger(position, mode=1, angle_step=5, enable=False).any()
    assert not sample_trigger(position, mode=0, sample_period=5, enable=False).any()
