"""The speed profile: the angle is the integral of the speed."""

import numpy as np
import pytest

from arctrue.table import Motion


def test_angle_is_the_integral_of_the_speed() -> None:
    motion = Motion((0.0, 0.5, 2.0, 2.6, 3.0), (0.0, 2.0, 2.0, -1.0, 0.0), 0.3, 0.002, 7, 1.0)
    time_s = np.linspace(0, motion.duration_s, 300_001)
    state = motion.state(time_s)
    step = time_s[1]
    integral = np.concatenate(
        [[0.0], np.cumsum((state.speed_rad_s[1:] + state.speed_rad_s[:-1]) / 2)]
    )
    # trapezoid rule on a 10 µs grid: error below step² × max of the second derivative
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
