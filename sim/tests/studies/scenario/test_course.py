"""Tests of the table's course, which is its motion over several legs, against travel, angle and
time that the tests compute by other means."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.studies.scenario.course import Course, Leg
from arctrue.studies.scenario.scenario import Scale, Scenario, TableErrors, TemperaturePoint

SPEED_RAD_S = float(np.deg2rad(40.0))
LEGS = (
    Leg(turns=1.5, speed_rad_s=SPEED_RAD_S),
    Leg(pause_s=600.0, run_s=0.4),
    Leg(turns=-0.5, speed_rad_s=2 * SPEED_RAD_S),
)


def test_travel_and_angle() -> None:
    course = Course.over(LEGS)
    time_s = np.linspace(0.0, course.duration_s, 20_001)
    state = course.state(time_s)
    travel = course.travel_turns(time_s)
    # Compare with the trapezoidal integral of |speed|, which is exact except in time steps in which
    # the slope of the speed changes.
    steps = np.abs(state.speed_rad_s)
    integral = np.concatenate([[0.0], np.cumsum(np.diff(time_s) * (steps[1:] + steps[:-1]) / 2)])
    assert np.abs(travel - travel[0] - integral / (2 * np.pi)).max() < 1e-5
    assert course.turns == pytest.approx(2.0)
    # The table goes forward by 1.5 turns and back by half a turn.
    begin = float(course.state(np.array([course.time_at_turn(0.0)])).angle_rad[0])
    assert state.angle_rad[-1] - begin == pytest.approx(2 * np.pi)
    # Both indices, at −33° and 0°, lie before the first turn.
    assert state.angle_rad[0] < -np.deg2rad(33.0)
    assert begin == pytest.approx(np.deg2rad(1.0))


@pytest.mark.parametrize("turn", [0.0, 0.001, 0.7, 1.5, 1.501, 1.9999, 2.0])
def test_time_of_a_turn_is_the_inverse(turn: float) -> None:
    course = Course.over(LEGS)
    instant = course.time_at_turn(turn)
    assert course.travel_turns(np.array([instant]))[0] == pytest.approx(turn, abs=1e-9)
    assert course.travel_turns(np.array([instant - 1e-4]))[0] < turn


def test_a_pause_is_short_for_the_motion_and_long_for_the_heat() -> None:
    temperature = (
        TemperaturePoint(20.0, 1.5),
        TemperaturePoint(26.0, 1.5, 600.0),
    )
    scenario = Scenario("", "", Scale(), TableErrors(), LEGS, temperature=temperature)
    course = scenario.course()
    begin = course.time_at_turn(1.5)
    state = course.state(begin + np.array([-1.0, 0.0, 0.1, 0.41, 1.0]))
    # The executed part of the pause, 0.4 s, is rounded to whole sample periods of 10 ms, so that it
    # may differ by half a period.
    half_a_period = 0.005 / 0.4
    assert state.temperature_c == pytest.approx([20.0, 20.0, 21.5, 26.0, 26.0], rel=half_a_period)
    assert np.diff(state.since_run_start_s) == pytest.approx(
        [1.0, 150.0, 450.0, 0.6], rel=half_a_period, abs=0.02
    )
    assert np.diff(state.time_s) == pytest.approx([1.0, 0.1, 0.31, 0.59])


def test_the_side_of_approach() -> None:
    course = Course.over(LEGS)
    # The table reverses after the pause at turn 1.5; 15° later its side of approach is the other
    # one.
    instants = [course.time_at_turn(turn) for turn in (0.5, 1.49, 1.5, 1.5 + 15 / 360, 1.9)]
    direction = course.state(np.array(instants)).direction
    assert direction == pytest.approx([1, 1, 1, -1, -1])


@pytest.mark.parametrize("turns", [0.3, 0.7, 1.1, 2.5, 3.3, 7.9])
def test_the_turn_of_a_pause_is_its_beginning(turns: float) -> None:
    leg = Leg(turns=turns, speed_rad_s=SPEED_RAD_S)
    course = Course.over((leg, LEGS[1], leg))
    # The course's knots are: start, end of the run-up, start of the braking, standstill (number 3,
    # the beginning of the pause), and end of the pause.
    assert course.time_at_turn(turns) == pytest.approx(course.knot_times_s[3], abs=1e-6)


@pytest.mark.parametrize(
    "legs", [(), (Leg(pause_s=1, run_s=1),), (LEGS[0], Leg(turns=0.001, speed_rad_s=1.0))]
)
def test_legs_that_cannot_be_driven(legs: tuple[Leg, ...]) -> None:
    with pytest.raises(ValueError, match=r"index|run-up"):
        Course.over(legs)
