"""Tests of each physical cause against a first-order formula derived by hand.

The formulas neglect (e/R)², where e is the largest displacement and R the radius of the disc. The
neglected part is 7e-5″ at 1 µm; tests of such formulas therefore allow ``TOLERANCE_RAD``, 1e-4″.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import jv

from arctrue.table import HEAD_SEPARATION_RAD, RotaryTable, two_heads
from arctrue.table.cause import Cause, Stations
from arctrue.table.causes.autocollimator_scale import AutocollimatorScale
from arctrue.table.causes.ball_pass import BallPass
from arctrue.table.causes.belt_half_order import BeltPull
from arctrue.table.causes.bracket_expansion import BracketExpansion
from arctrue.table.causes.bracket_turn import BracketTurn
from arctrue.table.causes.bracket_vibration import BracketVibration
from arctrue.table.causes.centrifugal_lobes import CentrifugalLobes
from arctrue.table.causes.gear_mesh import GearMesh
from arctrue.table.causes.graduation_bump import GraduationBump
from arctrue.table.causes.instrument_drift import InstrumentDrift
from arctrue.table.causes.lost_counts import LostCounts
from arctrue.table.causes.polygon_faces import PolygonFaces
from arctrue.table.causes.polygon_mounting import PolygonMounting
from arctrue.table.causes.radial_motion import RadialMotion
from arctrue.table.causes.reading_latency import ReadingLatency
from arctrue.table.causes.sampling_skew import SamplingSkew
from arctrue.table.causes.settling_bracket import SettlingBracket
from arctrue.table.causes.shaft_wind_up import ShaftWindUp
from arctrue.table.causes.signal_distortion import SignalDistortion
from arctrue.table.causes.thermal_centre import ThermalCentre
from arctrue.table.causes.warm_lobes import WarmLobes
from arctrue.table.conditions import Conditions

Float = NDArray[np.float64]
ARCSEC = np.pi / 648_000
RADIUS_M = 53.975e-3
ALPHA = np.deg2rad(33.0)
TOLERANCE_RAD = 1e-4 * ARCSEC
ANGLE = np.linspace(-1.0, 4 * np.pi, 401)
HEADS = two_heads()


def conditions(
    *,
    temperature_c: Float | float = 20.0,
    direction: float = 1.0,
    speed_rad_s: float = 0.5,
    run: int = 0,
    start_s: float = 0.0,
) -> Conditions:
    ones = np.ones_like(ANGLE)
    since_s = np.linspace(0.0, 30.0, ANGLE.size)
    return Conditions(
        start_s + since_s,
        ANGLE,
        speed_rad_s * ones,
        temperature_c * ones,
        direction * ones,
        np.full(ANGLE.size, run),
        since_s,
    )


def error(effect: Cause, head: int, state: Conditions) -> Float:
    """Return the reading minus the reading of a perfect table."""
    table = RotaryTable(HEADS, (effect,))
    return np.asarray(table.reading_rad(head, state) - ANGLE - (ALPHA if head else 0.0))


def test_geometry_is_the_papers() -> None:
    assert pytest.approx(ALPHA) == HEAD_SEPARATION_RAD
    assert abs(HEADS[0].point_m) == pytest.approx(RADIUS_M)


@pytest.mark.parametrize("head", [0, 1])
def test_bracket_turned_towards_minus_reads_more(head: int) -> None:
    effect = BracketTurn(1, HEADS[1], -5 * ARCSEC)
    expected = 5 * ARCSEC * head
    np.testing.assert_allclose(error(effect, head, conditions()), expected, atol=TOLERANCE_RAD)


def test_bracket_grows_with_heat() -> None:
    temperature_c = np.linspace(18.0, 24.0, ANGLE.size)
    effect = BracketExpansion(1, HEADS[1], -0.3 * ARCSEC)
    state = conditions(temperature_c=temperature_c)
    expected = 0.3 * ARCSEC * (temperature_c - 20)
    np.testing.assert_allclose(error(effect, 1, state), expected, atol=TOLERANCE_RAD)
    np.testing.assert_allclose(error(effect, 0, state), 0, atol=1e-15)


@pytest.mark.parametrize("each_run", [False, True])
def test_bracket_settles(each_run: bool) -> None:
    state = conditions(run=1, start_s=7.0)
    effect = SettlingBracket(1, HEADS[1], -2 * ARCSEC, 10.0, each_run)
    since_s = np.linspace(0.0, 30.0, ANGLE.size) + (0.0 if each_run else 7.0)
    expected = 2 * ARCSEC * np.exp(-since_s / 10)
    np.testing.assert_allclose(error(effect, 1, state), expected, atol=TOLERANCE_RAD)


def test_bracket_shakes_with_a_phase_a_run() -> None:
    effect = BracketVibration(0, HEADS[0], 0.4 * ARCSEC, 2.5, (0.3, 1.7))
    for run, phase in enumerate((0.3, 1.7)):
        state = conditions(run=run)
        expected = -0.4 * ARCSEC * np.sin(2 * np.pi * 2.5 * state.time_s + phase)
        np.testing.assert_allclose(error(effect, 0, state), expected, atol=TOLERANCE_RAD)


def centre_seen(x_m: Float, y_m: Float, head: int) -> Float:
    """Return the change of a head's reading when the disc's centre is at (x, y): the change is y/R
    at head 1 and (x·sin α + y·cos α)/R at head 2."""
    if head == 0:
        return y_m / RADIUS_M
    return np.asarray((x_m * np.sin(ALPHA) + y_m * np.cos(ALPHA)) / RADIUS_M)


@pytest.mark.parametrize("head", [0, 1])
def test_axis_on_an_ellipse(head: int) -> None:
    effect = RadialMotion(3, 0.3e-6 * np.exp(0.4j), 0.2e-6 * np.exp(-1.1j))
    x = 0.3e-6 * np.cos(3 * ANGLE + 0.4) + 0.2e-6 * np.cos(3 * ANGLE + 1.1)
    y = 0.3e-6 * np.sin(3 * ANGLE + 0.4) - 0.2e-6 * np.sin(3 * ANGLE + 1.1)
    np.testing.assert_allclose(
        error(effect, head, conditions()), centre_seen(x, y, head), atol=TOLERANCE_RAD
    )


@pytest.mark.parametrize("head", [0, 1])
def test_axis_on_a_line(head: int) -> None:
    effect = RadialMotion.along(2, 0.5e-6, 0.7, 0.2)
    size = 0.5e-6 * np.cos(2 * ANGLE + 0.2)
    expected = centre_seen(size * np.cos(0.7), size * np.sin(0.7), head)
    np.testing.assert_allclose(error(effect, head, conditions()), expected, atol=TOLERANCE_RAD)


@pytest.mark.parametrize("head", [0, 1])
def test_balls_do_not_close_after_a_turn(head: int) -> None:
    effect = BallPass(9.57, 0.2e-6 + 0j)
    expected = centre_seen(0.2e-6 * np.cos(9.57 * ANGLE), 0.2e-6 * np.sin(9.57 * ANGLE), head)
    np.testing.assert_allclose(error(effect, head, conditions()), expected, atol=TOLERANCE_RAD)


@pytest.mark.parametrize("head", [0, 1])
def test_belt_pulls_every_second_turn(head: int) -> None:
    effect = BeltPull(0.5, 0.4e-6, 1.2, 0.3)
    size = 0.4e-6 * np.cos(0.5 * ANGLE + 0.3)
    expected = centre_seen(size * np.cos(1.2), size * np.sin(1.2), head)
    np.testing.assert_allclose(error(effect, head, conditions()), expected, atol=TOLERANCE_RAD)


@pytest.mark.parametrize("head", [0, 1])
def test_warm_disc_is_off_centre(head: int) -> None:
    effect = ThermalCentre(0.25e-6 * np.exp(0.6j))
    expected = 4 * 0.25e-6 / RADIUS_M * np.sin(ANGLE + ALPHA * head + 0.6)
    state = conditions(temperature_c=24.0)
    np.testing.assert_allclose(error(effect, head, state), expected, atol=TOLERANCE_RAD)
    np.testing.assert_allclose(error(effect, head, conditions()), 0, atol=1e-15)


@pytest.mark.parametrize("head", [0, 1])
def test_warm_disc_is_oval(head: int) -> None:
    effect = WarmLobes(2, 0.3 * ARCSEC, 0.9)
    expected = 1.5 * 0.3 * ARCSEC * np.cos(2 * (ANGLE + ALPHA * head) + 0.9)
    state = conditions(temperature_c=21.5)
    np.testing.assert_allclose(error(effect, head, state), expected, atol=TOLERANCE_RAD)


@pytest.mark.parametrize("head", [0, 1])
def test_fast_disc_has_lobes(head: int) -> None:
    effect = CentrifugalLobes(3, 0.2 * ARCSEC, 0.9)
    expected = 1.5**2 * 0.2 * ARCSEC * np.cos(3 * (ANGLE + ALPHA * head) + 0.9)
    state = conditions(speed_rad_s=-1.5)
    np.testing.assert_allclose(error(effect, head, state), expected, atol=TOLERANCE_RAD)


@pytest.mark.parametrize("head", [0, 1])
def test_scratch_is_seen_by_both_heads_alpha_apart(head: int) -> None:
    effect = GraduationBump(3 * ARCSEC, 2.0, 0.01)
    found = error(effect, head, conditions())
    disc = np.mod(ANGLE + ALPHA * head, 2 * np.pi)
    np.testing.assert_allclose(
        found, 3 * ARCSEC * np.exp(-0.5 * ((disc - 2) / 0.01) ** 2), atol=TOLERANCE_RAD
    )


def test_signal_offset_returns_once_a_period_gain_and_phase_twice() -> None:
    lines = 64
    share = 1e-4
    phase = lines * ANGLE
    cases = (
        (SignalDistortion(0, lines, cosine_offset=share), -share * np.sin(phase)),
        (SignalDistortion(0, lines, sine_offset=share), share * np.cos(phase)),
        (SignalDistortion(0, lines, gain_difference=share), -share / 2 * np.sin(2 * phase)),
        (SignalDistortion(0, lines, phase_error_rad=share), share * np.cos(phase) ** 2),
    )
    for effect, expected in cases:
        # The formulas neglect the square of ``share``.
        np.testing.assert_allclose(
            error(effect, 0, conditions()), expected / lines, atol=share**2 / lines
        )
        np.testing.assert_allclose(error(effect, 1, conditions()), 0, atol=1e-15)


def test_shaft_and_gear_turn_the_disc() -> None:
    up, down = conditions(), conditions(direction=-1.0)
    np.testing.assert_allclose(ShaftWindUp(2e-6).disc_turn_rad(up), 2e-6)
    np.testing.assert_allclose(ShaftWindUp(2e-6).disc_turn_rad(down), -2e-6)
    gear = GearMesh(90, (3e-6, 1e-6), (0.1, 0.2))
    expected = 3e-6 * np.cos(90 * ANGLE + 0.1) + 1e-6 * np.cos(180 * ANGLE + 0.2)
    np.testing.assert_allclose(gear.disc_turn_rad(up), expected)


def test_delays_of_the_heads() -> None:
    assert [SamplingSkew(3e-6).sampling_delay_s(head) for head in (0, 1)] == [0.0, -3e-6]
    assert [ReadingLatency(3e-6).sampling_delay_s(head) for head in (0, 1)] == [3e-6, 3e-6]


def test_counts_are_lost_from_one_instant_on() -> None:
    state = conditions(run=1)
    after = state.since_run_start_s >= 11.0
    slip = LostCounts(1, 1, 11.0, -8)
    np.testing.assert_array_equal(slip.gained_counts(1, state), np.where(after, -8, 0))
    assert np.all(slip.gained_counts(0, state) == 0)
    assert np.all(slip.gained_counts(1, conditions(run=2)) == 0)
    for_good = LostCounts(1, 1, 11.0, -8, for_good=True)
    assert np.all(for_good.gained_counts(1, conditions(run=2)) == -8)


def test_errors_of_the_instrument() -> None:
    state = conditions()
    stations = Stations(state, np.arange(ANGLE.size) % 24)
    deviation = np.sin(ANGLE) * 50 * ARCSEC
    faces = PolygonFaces(tuple((np.arange(24) * ARCSEC).tolist()))
    np.testing.assert_allclose(
        faces.instrument_error_rad(stations, deviation), (np.arange(ANGLE.size) % 24) * ARCSEC
    )
    np.testing.assert_allclose(
        AutocollimatorScale(-0.01).instrument_error_rad(stations, deviation), -0.01 * deviation
    )
    np.testing.assert_allclose(
        InstrumentDrift(2e-9).instrument_error_rad(stations, deviation), 2e-9 * state.time_s
    )


def test_a_polygon_before_a_rolled_autocollimator_by_the_law_of_reflection() -> None:
    """The cause equals the law of reflection, which the test computes with vectors for beam, face
    and sensor; the cause neglects terms of second order."""
    deviation = np.sin(ANGLE) * 50 * ARCSEC
    tilt, roll, phase = 60 * ARCSEC, np.deg2rad(2.0), 0.4
    offset, flatness, width = 0.5e-3, 0.03e-6, 10e-3
    # A hollow mirror is a parabola of depth h over the width H: z = 4h(x/H)², with the slope
    # 8hx/H².
    x = offset * np.cos(ANGLE + phase)
    step = 1e-6
    parabola = 4.0 * flatness * ((x + step) ** 2 - (x - step) ** 2) / width**2
    direction = deviation + parabola / (2.0 * step)
    lean = -tilt * np.sin(ANGLE + phase)
    normal = np.stack(
        [np.cos(lean) * np.cos(direction), np.cos(lean) * np.sin(direction), np.sin(lean)]
    )
    beam = np.array([-1.0, 0.0, 0.0])[:, np.newaxis]
    back = beam - 2.0 * np.sum(beam * normal, axis=0) * normal
    # The sensor is turned about the line of sight; a mirror doubles the angle.
    along = back[1] * np.cos(roll) + back[2] * np.sin(roll)
    expected = np.arctan2(along, back[0]) / 2.0 - deviation
    cause = PolygonMounting(offset, flatness, width, tilt, float(roll), phase)
    made = cause.instrument_error_rad(Stations(conditions(), np.zeros(ANGLE.size, int)), deviation)
    assert np.abs(made - expected).max() < (tilt + 50 * ARCSEC) ** 2
    assert np.abs(made).max() > 2 * ARCSEC


def test_an_autocollimator_does_not_see_that_the_polygon_is_off_the_axis() -> None:
    """An autocollimator does not see a polygon off the axis: equation (14) gives 8sh/H²·ρ =
    0.00015″ for an offset of 0.3 µm; an encoder of 30 mm radius would then have 2.06″."""
    cause = PolygonMounting(0.3e-6, 0.03e-6, 10e-3, 0.0, np.deg2rad(1.0), 0.0)
    still = np.zeros(ANGLE.size)
    made = cause.instrument_error_rad(Stations(conditions(), np.zeros(ANGLE.size, int)), still)
    assert np.abs(made).max() / ARCSEC == pytest.approx(0.00015, abs=2e-6)


def test_wind_up_goes_over_within_its_stroke() -> None:
    travel = np.linspace(0.0, 0.3, ANGLE.size)
    up = replace(conditions(), since_reversal_rad=travel)
    found = ShaftWindUp(2e-6, 0.05).disc_turn_rad(up)
    # At the reversal the wind-up is still on the old side. After ln 2 strokes it is zero, and at
    # the end it is on the new side.
    assert found[0] == pytest.approx(-2e-6)
    assert np.interp(0.05 * np.log(2), travel, found) == pytest.approx(0.0, abs=2e-9)
    assert found[-1] == pytest.approx(2e-6 * (1 - 2 * np.exp(-6)))


def test_dirt_has_a_flat_top_and_two_sides() -> None:
    bump = GraduationBump(1.0, 2.0, 0.1, power=6.0, skew=0.5)
    at = np.array([1.96, 2.0, 2.1, 2.15, 2.3])
    found = bump.graduation_error_rad(at, conditions())
    away = np.array([0.04 / 0.05, 0.0, 0.1 / 0.15, 1.0, 2.0])
    np.testing.assert_allclose(found, np.exp(-0.5 * away**6), rtol=1e-9)


def test_wobbling_pitch_puts_lines_next_to_the_order_of_the_teeth() -> None:
    gear = GearMesh(20, (1e-6,), (0.0,), 0.3, 0.7)
    angle = np.arange(1024) * (2 * np.pi / 1024)
    ones = np.ones_like(angle)
    state = Conditions(ones, angle, ones, ones, ones, np.zeros(1024, dtype=np.int64), ones)
    lines = 2 * np.abs(np.fft.rfft(gear.disc_turn_rad(state))) / 1024
    # By the Jacobi-Anger expansion the amplitude is J0 at the order of the teeth, and J1 at the
    # neighbouring lines.
    np.testing.assert_allclose(lines[[19, 20, 21]], 1e-6 * jv([1, 0, 1], 0.3), rtol=1e-3)


def test_drift_follows_its_temperature() -> None:
    state = conditions()
    stations = Stations(state, np.zeros(ANGLE.size, dtype=np.int64))
    drift = InstrumentDrift(1e-9, (0.0, 10.0, 20.0), (0.0, 5e-9, -2e-9))
    found = np.interp([5.0, 15.0, 30.0], state.time_s, drift.instrument_error_rad(stations, ANGLE))
    np.testing.assert_allclose(found, [7.5e-9, 16.5e-9, 28e-9], rtol=1e-6)
