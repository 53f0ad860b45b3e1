"""Tests that the angle of a motion is the integral of its speed profile."""

import numpy as np
import pytest

from arctrue.table import Motion
from arctrue.table.temperature import TemperatureCourse


def test_angle_is_the_integral_of_the_speed() -> None:
    motion = Motion((0.0, 0.5, 2.0, 2.6, 3.0), (0.0, 2.0, 2.0, -1.0, 0.0), 0.3, 0.002, 7, 1.0)
    time_s = np.linspace(0, motion.duration_s, 300_001)
    state = motion.state(time_s)
    step = time_s[1]
    integral = np.concatenate(
        [[0.0], np.cumsum((state.speed_rad_s[1:] + state.speed_rad_s[:-1]) / 2)]
    )
    # The trapezoidal rule on a 10 µs grid errs by less than step² times the largest second
    # derivative.
    np.testing.assert_allclose(state.angle_rad, 0.3 + integral * step, rtol=0, atol=1e-9)


def test_ramps_lie_within_the_motion() -> None:
    motion = Motion.steady(3.0, 4.0, ramp_s=0.5)
    ends = motion.state(np.array([0.0, 4.0]))
    assert ends.speed_rad_s.tolist() == [0.0, 0.0]
    assert ends.angle_rad[1] == pytest.approx(3.0 * 3.5)


def test_turning_times_hold_every_reversal() -> None:
    motion = Motion((0.0, 1.0, 3.0), (1.0, 1.0, -1.0))
    assert motion.turning_times_s() == pytest.approx([0.0, 1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (((0.0,), (1.0,)), "two or more knots"),
        (((1.0, 2.0), (1.0, 1.0)), "begin at 0"),
        (((0.0, 2.0, 1.0), (1.0, 1.0, 1.0)), "rise"),
        (((0.0, float("nan")), (1.0, 1.0)), "rise"),
        (((0.0, 1.0), (1.0, 1.0), 0.0, 0.2, 7), "turn the table back"),
    ],
)
def test_impossible_motions_are_refused(arguments: tuple[object, ...], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Motion(*arguments)  # type: ignore[arg-type]


def test_instants_outside_the_motion_are_refused() -> None:
    with pytest.raises(ValueError, match="lasts from 0 to 1"):
        Motion.steady(1.0, 1.0).state(np.array([1.5]))
    with pytest.raises(ValueError, match="do not fit"):
        Motion.steady(1.0, 1.0, ramp_s=0.6)


def test_side_and_travel_through_reversals_and_pauses() -> None:
    # The motion goes up, stops and goes down, pauses, and goes up again. The distances travelled
    # are computed by hand: 0, 3, 3.75 (at 3 s, where the table turns back), 4.5, 5.25, 5.25 and
    # 6.25 rad.
    motion = Motion((0.0, 2.0, 4.0, 5.0, 7.0, 9.0), (1.5, 1.5, -1.5, 0.0, 0.0, 1.0))
    state = motion.state(np.array([0.0, 1.0, 2.5, 3.5, 4.5, 6.0, 8.0, 9.0]))
    np.testing.assert_array_equal(state.direction, [1, 1, 1, -1, -1, -1, 1, 1])
    travelled = np.array([0.0, 1.5, 3.5625, 3.9375, 5.0625, 5.25, 5.5, 6.25])
    np.testing.assert_allclose(state.travelled_rad, travelled, atol=1e-12)
    since = travelled - np.array([0, 0, 0, 3.75, 3.75, 3.75, 5.25, 5.25])
    np.testing.assert_allclose(state.since_reversal_rad, since, atol=1e-12)


def test_travel_is_the_integral_of_the_speed() -> None:
    motion = Motion((0.0, 1.0, 3.0, 3.5, 6.0), (0.0, 2.0, -1.0, -1.0, 3.0))
    time_s = np.linspace(0.0, 6.0, 60_001)
    speed = np.abs(motion.state(time_s).speed_rad_s)
    integral = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(time_s))])
    # The trapezoidal rule errs in the steps in which the speed passes zero, each time by less than
    # (2 rad/s² · 1e-4 s) · 1e-4 s = 2e-8 rad.
    np.testing.assert_allclose(motion.travel_rad(time_s), integral, atol=1e-7)


def test_a_motion_that_begins_later_and_warms() -> None:
    course = TemperatureCourse((100.0, 110.0), (20.0, 25.0))
    motion = Motion(
        (0.0, 1.0, 2.0),
        (1.0, 1.0, 0.0),
        temperature=course,
        surroundings_s=(0.0, 1.0, 9.0),
        start_s=100.0,
        run=3,
        travelled_rad=7.0,
    )
    state = motion.state(np.array([0.5, 1.5]))
    np.testing.assert_allclose(state.time_s, [100.5, 101.5])
    np.testing.assert_allclose(state.since_run_start_s, [0.5, 5.0])
    np.testing.assert_allclose(state.temperature_c, [20.25, 22.5])
    np.testing.assert_array_equal(state.run, [3, 3])
    np.testing.assert_allclose(state.travelled_rad, [7.5, 8.375])
    with pytest.raises(ValueError, match="one time a knot"):
        Motion((0.0, 1.0), (1.0, 1.0), surroundings_s=(0.0,))
