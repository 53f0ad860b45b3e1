"""Tests of the drive: the angles where the table stands, the direction of approach, the
temperature, and the wind-up of the shaft after a reversal."""

from __future__ import annotations

import numpy as np

from arctrue.studies.hidden_effect.cases import STROKE_RAD
from arctrue.studies.hidden_effect.drive import over_stations, turning
from arctrue.table.causes.shaft_wind_up import ShaftWindUp


def test_a_turning_drive_passes_both_indices_and_its_turns() -> None:
    for speed in (0.5, -0.5):
        drive = turning(speed, 2.0, temperature_c=(20.0, 24.0))
        ends = drive.state(np.array([0.0, drive.duration_s]))
        low, high = sorted(ends.angle_rad)
        # The index of head 2 is at −33°, that of head 1 at 0.
        assert low < -np.deg2rad(33.0)
        assert high > 0.0
        assert high - low > 2.0 * 2 * np.pi + np.deg2rad(33.0)
        assert ends.temperature_c.tolist() == [20.0, 24.0]
        assert ends.direction.tolist() == [np.sign(speed)] * 2


def test_stations_are_reached_from_their_side_and_stood_at() -> None:
    plan = over_stations(0.5, 6, 2, stop_s=0.1)
    state = plan.drive.state(plan.station_s)
    assert plan.target_deg.tolist() == [0, 60, 120, 180, 240, 300, 300, 240, 180, 120, 60, 0] * 2
    assert plan.direction.tolist() == ([1] * 6 + [-1] * 6) * 2
    assert plan.cycle.tolist() == [0] * 12 + [1] * 12
    np.testing.assert_allclose(np.rad2deg(state.angle_rad), plan.target_deg, atol=1e-9)
    np.testing.assert_array_equal(state.speed_rad_s, 0.0)
    np.testing.assert_array_equal(state.direction, plan.direction)
    shortly_before = plan.drive.state(plan.station_s - 0.3)
    moved = state.angle_rad - shortly_before.angle_rad
    assert np.all(np.sign(moved) == plan.direction)


def test_the_wind_up_goes_over_within_its_stroke_at_a_reversal() -> None:
    plan = over_stations(0.5, 6, 1, stop_s=0.1)
    seconds = np.linspace(0.0, plan.drive.duration_s, 20_001)
    state = plan.drive.state(seconds)
    turn = np.asarray(ShaftWindUp(1.0, STROKE_RAD).disc_turn_rad(state))
    # The slope of Dahl's model is at most 2/stroke, and the speed is 0.5 rad/s.
    most = 2.0 / STROKE_RAD * 0.5 * (seconds[1] - seconds[0])
    assert np.max(np.abs(np.diff(turn))) < 1.001 * most
    # The table turns at least 60 strokes after a reversal before it reaches a station; there the
    # wind-up differs from its final value by at most 2·exp(-60).
    at = plan.drive.state(plan.station_s)
    stood = ShaftWindUp(1.0, STROKE_RAD).disc_turn_rad(at)
    np.testing.assert_allclose(stood, plan.direction, atol=1e-12)
