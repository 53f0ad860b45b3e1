"""Tests of the servo against its equations, and of the stored experiment against the geometry."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.report.charts.stop_and_go_picture import plot_stop_and_go
from arctrue.report.stop_and_go_page import stop_and_go_page
from arctrue.studies.revolution import RevolutionSettings
from arctrue.studies.stop_and_go.experiment import StopAndGoSettings, run_stop_and_go
from arctrue.studies.stop_and_go.servo import Axis, Controller, Moves, drive
from arctrue.table import TableState

ROOT = Path(__file__).resolve().parents[4]
FOUND = json.loads((ROOT / "docs" / "data" / "stop-and-go.json").read_text(encoding="utf-8"))
COUNT_RAD = 2.0 * np.pi / (1 << 24)


@pytest.mark.large
def test_the_path_is_the_integral_of_its_speed() -> None:
    moves = Moves(np.array([0.0, 1.0, 0.2]), np.array([0.3, 0.5, 0.2004]))
    time = np.arange(0.0, moves.duration_s, 1e-4)
    place = np.array([moves.path(float(t))[0] for t in time])
    speed = np.array([moves.path(float(t))[1] for t in time])
    integral = moves.start_rad + np.cumsum(speed, axis=0) * 1e-4
    np.testing.assert_allclose(place[1:], integral[:-1], atol=5e-5)
    np.testing.assert_allclose(moves.path(moves.duration_s)[0], moves.target_rad, atol=1e-12)
    assert np.abs(speed).max() <= moves.speed_rad_s + 1e-12


def test_sliding_rubs_as_stribeck_says_and_standing_bends() -> None:
    """At constant speed the friction torque is the sum of the Stribeck torque and a viscous part. A
    torque below the static friction only bends the bristles of the LuGre model, by the torque
    divided by their stiffness σ₀."""
    axis, step_s = Axis(), 1e-4
    speed, bend = np.array([0.005, 0.5]), np.zeros(2)
    for _ in range(5000):
        torque, bend = axis.friction(speed, bend, step_s)
    level = axis.coulomb_n_m + (axis.static_n_m - axis.coulomb_n_m) * np.exp(
        -((speed / axis.stribeck_rad_s) ** 2)
    )
    np.testing.assert_allclose(torque, level + axis.viscous_n_m_s * speed, rtol=1e-6)
    moved, rate, bend = np.zeros(1), np.zeros(1), np.zeros(1)
    for number in range(10_000):
        pushed = 0.1 * min(1.0, number / 8_000)
        torque, bend = axis.friction(rate, bend, step_s)
        rate = rate + (pushed - torque) / axis.inertia_kg_m2 * step_s
        moved = moved + rate * step_s
    assert bend[0] == pytest.approx(0.1 / axis.bristle_n_m_rad, rel=1e-3)
    # For slow motion z′ = v·(1 − z/z_c) integrates to x = −z_c·ln(1 − z/z_c), where z_c is the
    # static torque over σ₀.
    most = axis.static_n_m / axis.bristle_n_m_rad
    assert moved[0] == pytest.approx(-most * np.log1p(-bend[0] / most), rel=0.02)


def test_the_servo_brings_the_signal_to_the_target() -> None:
    """The table stops less than two counts from the target: the signal is rounded down by up to one
    count, and the loop does not react within one count."""

    def shown(angle_rad: np.ndarray) -> np.ndarray:
        return np.floor(angle_rad / COUNT_RAD) * COUNT_RAD

    target = np.array([0.02, -0.02])
    stopped = drive(
        Axis(), Controller(), Moves(np.zeros(2), target), shown, COUNT_RAD, settle_s=0.8,
        dwell_s=0.1,
    )  # fmt: skip
    assert np.abs(stopped.angle_rad - target).max() < 2.0 * COUNT_RAD
    assert stopped.settled_s.max() < 0.8
    assert 0.0 < stopped.following_rad < 0.02


def test_raw_the_table_stops_where_the_geometry_says() -> None:
    """The table stops at target − ε with the raw signal; the test computes ε from the exact rays of
    the eccentric disc."""
    table = RevolutionSettings(noise_arcsec=0.0).table()
    target = np.arange(24) * (2.0 * np.pi / 24)
    stands = target.copy()
    for _ in range(6):
        stands += target - table.reading_rad(0, TableState.at_rest(stands))
    expected = (target - stands) * ARCSEC_PER_RAD
    found = np.array(FOUND["raw"]["true_mean_arcsec"])
    # The tolerance is 2.6 counts of the feedback. The true angle at a face scatters by at most
    # 0.01″ between the cycles.
    np.testing.assert_allclose(found, expected - expected.mean(), atol=0.2)


def test_corrected_the_table_stops_within_the_calibration() -> None:
    """With the corrected signal, the table stops near each target. The bound of 0.3″ is 2.5 times
    the calibration's U at one angle, 0.12″ (k = 2), because the test takes the largest of 24 faces.
    The same servo follows both signals, so that the stops scatter equally; the test allows a factor
    of 2."""
    assert np.abs(FOUND["corrected"]["true_mean_arcsec"]).max() < 0.3
    raw, corrected = (FOUND[name]["true_deviation_arcsec"] for name in ("raw", "corrected"))
    assert np.mean(corrected) < 2.0 * np.mean(raw)


def test_page_and_json_agree(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "stop-and-go.md").read_text(encoding="utf-8")
    assert page == stop_and_go_page(FOUND), "arctrue stop-and-go --page docs/stop-and-go.md ..."
    assert plot_stop_and_go(FOUND, tmp_path).stat().st_size > 5_000


def test_one_cycle_is_refused() -> None:
    with pytest.raises(ValueError, match="two cycles or more, found 1"):
        run_stop_and_go(StopAndGoSettings(cycles=1))
