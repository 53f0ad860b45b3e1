"""The drive: where the table stands, from which side it came, and how warm it is."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.studies.hidden_effect.drive import over_stations, turning


def test_a_turning_drive_passes_both_indices_and_its_turns() -> None:
    for speed in (0.5, -0.5):
        drive = turning(speed, 2.0, temperature_c=(20.0, 24.0))
        ends = drive.state(np.array([0.0, drive.duration_s]))
        low, high = sorted(ends.angle_rad)
        # Head 2's index is at −33°, head 1's at 0.
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


def test_the_side_changes_gradually_at_a_reversal() -> None:
    plan = over_stations(0.5, 6, 1, stop_s=0.1)
    seconds = np.linspace(0.0, plan.drive.duration_s, 20_001)
    side = plan.drive.state(seconds).direction
    step = seconds[1] - seconds[0]
    # Over a quarter of the run-up, from one side to the other.
    run_up_s = plan.drive.knot_times_s[1]
    assert np.max(np.abs(np.diff(side))) < 1.001 * 2 * step / (0.25 * run_up_s)
    assert side.min() == pytest.approx(-1.0)
    assert side.max() == pytest.approx(1.0)
