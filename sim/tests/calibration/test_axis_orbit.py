"""Tests that the orbit of the axis, computed from a capture of four heads, equals the motion of the
simulated table."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.calibration.axis_orbit import axis_orbit
from arctrue.cli import main
from arctrue.measurement import Capture, MeasurementSet, Table, write_measurement_set
from arctrue.metrology.iso230_7 import error_motion
from arctrue.studies.heads.self_calibrated_table import (
    COUNTS_PER_REV,
    PLACES_DEG,
    SPEED_RAD_S,
    SelfCalibratedTable,
)
from arctrue.table import DISC_RADIUS_M, Motion
from arctrue.table.causes.ball_pass import BallPass
from arctrue.table.causes.radial_motion import RadialMotion

AXIS = (RadialMotion.along(2, 0.5e-6, 0.6, 1.0), BallPass(4.37, 0.25e-6))
TURNS = 3


def test_the_orbit_is_the_motion_of_the_axis() -> None:
    """The orbit's x and y agree with the true motion within their uncertainty: the noise of the
    readings times the norm of a row of the inverse matrix."""
    table = replace(SelfCalibratedTable(), axis=AXIS)
    captured = table.captured(turns=TURNS)
    estimate = table.estimate(turns=TURNS)
    orbit = axis_orbit(captured, estimate.on_disc(), COUNTS_PER_REV, table.noise_arcsec)
    motion = Motion.steady(
        SPEED_RAD_S, TURNS * 2.0 * np.pi / SPEED_RAD_S + 1.0, start_rad=0.3, ripple_rad=0.002,
        ripple_order=7,
    )  # fmt: skip
    seconds = np.arange(orbit.angle_rad.size) * (2.0 * np.pi / SPEED_RAD_S / table.samples_a_turn)
    state = motion.state(seconds)
    shift = np.sum([cause.axis_shift_m(state) for cause in AXIS], axis=0)
    expected = (shift - shift.mean()) / DISC_RADIUS_M * ARCSEC_PER_RAD
    # Head 1 stands at the stator angle 0 and observes y; head 2 stands at the stator angle -p.
    for found, true, u in zip(
        (orbit.x_arcsec, orbit.y_arcsec),
        (expected.real, expected.imag),
        orbit.u_arcsec,
        strict=True,
    ):
        left = np.sqrt(np.mean((found - true) ** 2))
        assert left < 1.2 * u, f"{left:.3f}″ of {u:.3f}″"
        assert true.std() > 5.0 * u
    angle = np.unwrap(orbit.angle_rad)
    off = angle - state.angle_rad
    assert np.std(off) * ARCSEC_PER_RAD < 0.1


def test_figures_of_a_known_motion() -> None:
    """The error motion contains the motion of amplitude 1, which repeats in each turn, and the
    motion of amplitude 0.3, which does not. The eccentricity of 5 does not count as error
    motion."""
    angle = np.linspace(0.0, 20.0 * np.pi, 120_000, endpoint=False)
    motion = 5.0 * np.cos(angle + 0.4) + np.cos(3.0 * angle) + 0.3 * np.cos(4.37 * angle)
    found = error_motion(angle, motion)
    # Averaging over bins of two degrees reduces the repeating motion by 1 - cos(3 * 1°); the mean
    # of ten turns contains 0.3/10 of the motion that does not repeat.
    assert found.synchronous == pytest.approx(2.0, abs=0.09)
    # In ten turns, ten phases of the motion of amplitude 0.3 fall on the same angle. Within a bin
    # the phase of the repeating motion changes by 3 * 2°.
    assert found.asynchronous == pytest.approx(0.6, abs=0.11)
    assert found.total == pytest.approx(2.6, abs=0.05)


def test_two_heads_have_no_orbit() -> None:
    table = replace(SelfCalibratedTable(), places_deg=(0.0, 33.0))
    with pytest.raises(ValueError, match="3 heads or more"):
        axis_orbit(
            table.captured(), SelfCalibratedTable().estimate().on_disc(), COUNTS_PER_REV, 0.1
        )


def _compared(tmp_path: Path, places_deg: tuple[float, ...]) -> tuple[str, dict[str, Any]]:
    """Return the output of ``arctrue compare`` for a capture of these heads, and its JSON."""
    captured = replace(SelfCalibratedTable(), axis=AXIS, places_deg=places_deg).captured(
        turns=TURNS
    )
    names = ("head3_counts", "head4_counts")
    heads = dict(zip(names, captured.further_counts, strict=False))
    seconds = np.arange(captured.samples) * (12.0 / 12_000)
    capture = Capture(
        run=np.zeros(captured.samples, dtype=np.int64),
        time_s=seconds,
        head1_counts=captured.head1_counts,
        head2_counts=captured.head2_counts,
        **heads,
    )
    table = Table(counts_per_rev=COUNTS_PER_REV, head_places_deg=places_deg)
    write_measurement_set(tmp_path / "set", MeasurementSet(table, capture))
    file, out = tmp_path / "found.json", tmp_path / "out"
    words = ["compare", str(tmp_path / "set"), "--json", str(file), "--out", str(out)]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    assert (out / "axis_orbit.png").stat().st_size > 10_000
    return done.output, json.loads(file.read_text(encoding="utf-8"))["axis_orbit"]


@pytest.mark.large
def test_three_heads_state_no_synchronous_motion(tmp_path: Path) -> None:
    """The disc's calibration absorbs an unknown part of a motion that repeats in each turn."""
    output, found = _compared(tmp_path, PLACES_DEG[:3])
    assert "Three heads do not separate" in output
    for direction in ("x", "y"):
        assert found[direction]["synchronous_arcsec"] is None
        assert found[direction]["total_arcsec"] is None
        assert 0.9 < found[direction]["asynchronous_arcsec"] < 1.91 + 8.0 * 0.2


@pytest.mark.large
def test_compare_draws_the_orbit(tmp_path: Path) -> None:
    """``arctrue compare`` prints the orbit's figures of ISO 230-7 for x and for y, and draws the
    orbit, for a set of four heads."""
    output, found = _compared(tmp_path, PLACES_DEG)
    assert "ISO 230-7" in output
    # The axis moves by 0.5 µm at order 2 along a line at 0.6 rad. In x and y this is 3.82″ peak to
    # peak, times the cosine and the sine of this angle.
    size = 2.0 * 0.5e-6 / DISC_RADIUS_M * ARCSEC_PER_RAD
    for direction, share in (("x", np.cos(0.6)), ("y", np.sin(0.6))):
        # The mean of three turns contains a third of the ball motion, about 0.95″. Each bin
        # contains 200 samples with 0.1″ of noise.
        assert found[direction]["synchronous_arcsec"] == pytest.approx(size * share, abs=0.9)
        # The ball motion describes a circle with a diameter of 1.91″; its phases in three turns
        # cover more than half of this diameter.
        assert 0.9 < found[direction]["asynchronous_arcsec"] < 1.91 + 8.0 * 0.1
