"""Tests each cause of the independent generator against the first-order equation of this cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.studies.benchmark.independent.causes.cause import ARCSEC, Cause
from arctrue.studies.benchmark.independent.causes.disc import (
    AxisMotion,
    Backlash,
    BallPass,
    Defect,
    HighOrder,
    WarmCentre,
)
from arctrue.studies.benchmark.independent.causes.heads import (
    HeadStandsOff,
    LateHead,
    OldReading,
    Shaking,
    Slip,
    SubdivisionError,
    WarmBracket,
)
from arctrue.studies.benchmark.independent.causes.reference import (
    AngleLine,
    Creep,
    Faces,
    FirstOrderOfReference,
    GainOfReference,
    GearError,
    Line,
)
from arctrue.studies.benchmark.independent.causes.strangers import (
    AirDrag,
    BentScale,
    Chirp,
    FastLobes,
    LooseBracket,
    ReferenceJump,
    Sectors,
    SettlingBracket,
    TimeDrift,
    WarmOval,
    WobblingRoller,
)
from arctrue.studies.benchmark.independent.conditions import Sweep, stations
from arctrue.studies.benchmark.independent.geometry import Disc, swept_reading_rad
from arctrue.studies.benchmark.independent.scene import Scene

ALPHA = float(np.radians(33.0))
RADIUS_UM = 53_975.0
OMEGA = float(np.radians(30.0))
SWEEP = Sweep(0, 100.0, 0.4, OMEGA, np.linspace(0.0, 24.0, 1500, endpoint=False), warming_k=3.0)
THETA = 0.4 + OMEGA * SWEEP.time_s
TIME_S = 100.0 + SWEEP.time_s
SECOND_ORDER = 1e-6
"""Tolerance in arcseconds where the terms of second order, which the equations neglect, are smaller
than this."""
Float = NDArray[np.float64]


def difference(*causes: Cause, disc: Disc | None = None) -> Float:
    """Return R₂ − R₁ − α in arcseconds."""
    return Scene(disc or Disc(), runs=[SWEEP]).channels(causes)["capture"] - ALPHA / ARCSEC


def reading(head: int, causes: Sequence[Cause], sweep: Sweep = SWEEP) -> Float:
    return np.asarray(swept_reading_rad(Disc(), sweep, head, causes))


def arcsec_of_um(um: Float) -> Float:
    return um / RADIUS_UM / ARCSEC


def test_a_disc_off_centre_reads_the_angle_of_a_triangle() -> None:
    """The reading of an eccentric disc equals the exact geometry: if the disc's centre is at
    e·exp(jθ), the direction from this centre to the head at radius r turns by atan2(e·sin θ, r −
    e·cos θ)."""
    e = 40e-6
    found = swept_reading_rad(Disc(eccentricity_m=e + 0j), SWEEP, 1, [])
    triangle = np.arctan2(e * np.sin(THETA), 0.053975 - e * np.cos(THETA))
    np.testing.assert_allclose(found, THETA + triangle, rtol=0, atol=1e-12)
    # Head 2 shows exactly the same error, advanced by α; the transfer function assumes this.
    ahead = swept_reading_rad(Disc(eccentricity_m=e + 0j), SWEEP, 2, []) - THETA - ALPHA
    there = THETA + ALPHA
    triangle = np.arctan2(e * np.sin(there), 0.053975 - e * np.cos(there))
    np.testing.assert_allclose(ahead, triangle, rtol=0, atol=1e-12)


def test_graduation_is_advanced_by_the_order_times_alpha() -> None:
    disc = Disc(orders=np.array([0, 0, 2 * ARCSEC * np.exp(0.7j)]))
    expected = 2 * (np.cos(3 * (THETA + ALPHA) + 0.7) - np.cos(3 * THETA + 0.7))
    np.testing.assert_allclose(difference(disc=disc), expected, rtol=0, atol=SECOND_ORDER)
    high = HighOrder(0.5, 47, 0.2)
    expected = 0.5 * (np.cos(47 * (THETA + ALPHA) + 0.2) - np.cos(47 * THETA + 0.2))
    np.testing.assert_allclose(difference(high), expected, rtol=0, atol=SECOND_ORDER)


def test_axis_motion_is_seen_as_x_sin_alpha_and_y_cos_alpha() -> None:
    cause = AxisMotion(0.8, [2, 5], [1.0, 0.3j], [0.5j, 1.0])
    x = 0.8 * (np.cos(2 * THETA) - 0.3 * np.sin(5 * THETA))
    y = 0.8 * (-0.5 * np.sin(2 * THETA) + np.cos(5 * THETA))
    expected = arcsec_of_um(x * np.sin(ALPHA) + y * (np.cos(ALPHA) - 1))
    # 1 µm divided by the radius is 2·10⁻⁵; the equations neglect up to 2.5 times this share of 4″.
    np.testing.assert_allclose(difference(cause), expected, rtol=0, atol=2e-4)
    np.testing.assert_allclose(
        (reading(1, [cause]) - THETA) / ARCSEC, arcsec_of_um(y), rtol=0, atol=2e-4
    )


def test_ball_pass_and_roller_follow_the_unwrapped_angle() -> None:
    ball = BallPass(0.4, 7.31, 0.3, 0.5)
    x = 0.4 * np.cos(7.31 * THETA + 0.3)
    y = 0.2 * np.sin(7.31 * THETA + 0.3)
    expected = arcsec_of_um(x * np.sin(ALPHA) + y * (np.cos(ALPHA) - 1))
    np.testing.assert_allclose(difference(ball), expected, rtol=0, atol=1e-4)
    roller = WobblingRoller(0.4, 3.4, 80.0)
    push = 0.4 * np.sin(2 * np.pi * TIME_S / 80.0) * np.cos(3.4 * THETA)
    expected = arcsec_of_um(push * (np.sin(ALPHA) + np.cos(ALPHA) - 1))
    np.testing.assert_allclose(difference(roller), expected, rtol=0, atol=1e-4)


def test_heat_moves_the_centre_and_the_bracket() -> None:
    centre = WarmCentre(0.5, 0.9)
    expected = arcsec_of_um(1.5 * (np.sin(THETA + ALPHA + 0.9) - np.sin(THETA + 0.9)))
    np.testing.assert_allclose(difference(centre), expected, rtol=0, atol=1e-3)
    np.testing.assert_allclose(difference(WarmBracket(0.4)), -0.4 * 3.0, rtol=0, atol=SECOND_ORDER)
    oval = 0.4 * 3.0 * (np.cos(2 * (THETA + ALPHA)) - np.cos(2 * THETA))
    np.testing.assert_allclose(difference(WarmOval(0.4)), oval, rtol=0, atol=SECOND_ORDER)


def test_a_head_that_stands_off_moves_the_mean_and_the_slope_of_the_error() -> None:
    disc = Disc(orders=np.array([0, 30 * ARCSEC]))
    there = THETA + ALPHA + 20 * ARCSEC
    expected = 20 + 30 * (np.cos(2 * there) - np.cos(2 * THETA))
    found = difference(HeadStandsOff(20.0), disc=disc)
    np.testing.assert_allclose(found, expected, rtol=0, atol=SECOND_ORDER)


def test_offset_gain_and_phase_of_the_signals_are_their_first_harmonics() -> None:
    """The errors of the signals equal the first-order angle error of atan2, (Im o·cos φ − Re o·sin
    φ + g/2·sin 2φ + p/2·(1 + cos 2φ))/L."""
    cause = SubdivisionError(0.0, 2, 3e-3 + 2e-3j, 4e-3, 1e-3)
    phase = 16_384 * (THETA + ALPHA)
    first = 2e-3 * np.cos(phase) - 3e-3 * np.sin(phase)
    second = 2e-3 * np.sin(2 * phase) + 0.5e-3 * (1 + np.cos(2 * phase))
    expected = (first + second) / 16_384 / ARCSEC
    # The neglected products of two parameters are 1.2·10⁻⁵ rad of the phase, or 1.5·10⁻⁴″.
    np.testing.assert_allclose(difference(cause), expected, rtol=0, atol=3e-4)


def test_uneven_subdivision_is_larger_where_it_says() -> None:
    even = SubdivisionError(0.0, 2, 3e-3 + 0j, 0.0, 0.0)
    uneven = SubdivisionError(0.0, 2, 3e-3 + 0j, 0.0, 0.0, 0.2, 0.5)
    share = 1 + 0.2 * np.cos(THETA + ALPHA + 0.5)
    np.testing.assert_allclose(difference(uneven), share * difference(even), rtol=0, atol=3e-4)


def test_times_of_reading() -> None:
    late = difference(LateHead(20.0))
    np.testing.assert_allclose(late, -20e-6 * OMEGA / ARCSEC, rtol=1e-6)
    back = replace(SWEEP, speed_rad_s=-OMEGA)
    found = reading(2, [LateHead(20.0)], back) - reading(2, [], back)
    np.testing.assert_allclose(found, 20e-6 * OMEGA, rtol=1e-6)
    old = Scene(Disc(), passes=[SWEEP]).channels([OldReading(100.0)])["reference"]
    np.testing.assert_allclose(old, -100e-6 * OMEGA / ARCSEC, rtol=1e-6)


def test_shaking_settling_drag_and_creep_turn_one_bracket() -> None:
    shaking = Shaking(0.7, 1, 11.3, np.array([0.4]))
    wave = 0.7 * np.sin(2 * np.pi * 11.3 * TIME_S + 0.4)
    # Head 1 moves towards larger β: its reading decreases, and the difference increases.
    np.testing.assert_allclose(difference(shaking), wave, rtol=0, atol=SECOND_ORDER)
    for cause, bracket in (
        (SettlingBracket(2.0, 30.0), 2.0 * np.exp(-TIME_S / 30.0)),
        (AirDrag(2.0), np.full(TIME_S.size, 2.0)),
        (TimeDrift(36.0), 0.01 * TIME_S),
        (
            LooseBracket(2.0, np.array([105.003, 110.003])),
            2.0 * ((TIME_S > 105.003) & (TIME_S < 110.003)),
        ),
    ):
        np.testing.assert_allclose(difference(cause), -bracket, rtol=0, atol=SECOND_ORDER)


def test_a_slip_is_whole_counts_from_its_instant_in_its_run() -> None:
    expected = np.where(TIME_S >= 112.0, 7 * 1_296_000 / 2**24, 0.0)
    found = difference(Slip(7, 2, 0, 112.0))
    np.testing.assert_allclose(found, expected, rtol=0, atol=SECOND_ORDER)
    np.testing.assert_allclose(difference(Slip(7, 2, 1, 112.0)), 0.0, atol=SECOND_ORDER)


def test_a_defect_is_seen_twice_alpha_apart_with_opposite_signs() -> None:
    found = difference(Defect(2.0, 1.5, np.radians(3.0)))
    psi = np.mod(THETA, 2 * np.pi)
    assert psi[np.argmin(found)] == pytest.approx(1.5, abs=0.01)  # rows are 0.0084 rad apart
    assert psi[np.argmax(found)] == pytest.approx(1.5 - ALPHA, abs=0.01)
    # The row nearest to the top is up to half a row, 0.24°, away from it; there the bump has
    # cos(π/2·0.24/3)² of its height.
    assert found.max() == pytest.approx(2.0, rel=0.02)
    assert found.min() == pytest.approx(-2.0, rel=0.02)
    assert np.mean(np.abs(found) > 1.0) == pytest.approx(2 * np.radians(3.0) / (2 * np.pi), rel=0.1)


def test_sectors_and_fast_lobes_are_on_the_disc() -> None:
    wave = np.sign(np.sin(5 * (THETA + ALPHA) + 0.3)) - np.sign(np.sin(5 * THETA + 0.3))
    found = difference(Sectors(0.6, 5, 0.3))
    # A row within 2″ of an edge could be on either side of the edge; the sweep has no such row.
    np.testing.assert_allclose(found, 0.6 * wave, rtol=0, atol=SECOND_ORDER)
    fast = replace(SWEEP, speed_rad_s=3 * OMEGA)
    angle = 0.4 + 3 * OMEGA * SWEEP.time_s
    found = (reading(1, [FastLobes(0.2)], fast) - angle) / ARCSEC
    np.testing.assert_allclose(found, 9 * 0.2 * np.cos(3 * angle), rtol=0, atol=SECOND_ORDER)


AT = stations(np.arange(24) * (2 * np.pi / 24), 2, True, 6.0, 50.0)
TARGET = AT.at.turned_rad


def reference(*causes: Cause, disc: Disc | None = None) -> Float:
    return Scene(disc or Disc(), stations=AT).channels(causes)["reference"]


def test_a_servo_holds_the_reading_so_the_error_belongs_to_the_place_behind_it() -> None:
    disc = Disc(orders=np.array([0, 100 * ARCSEC]))
    error = reference(disc=disc)
    true = TARGET - error * ARCSEC
    np.testing.assert_allclose(error, 100 * np.cos(2 * true), rtol=0, atol=1e-9)


def test_play_shifts_the_error_by_half_of_it_in_either_sense() -> None:
    np.testing.assert_allclose(
        reference(Backlash(3.0)), -1.5 * AT.at.direction, rtol=0, atol=SECOND_ORDER
    )
    share = 1 + 0.2 * np.cos(TARGET + 0.4)
    np.testing.assert_allclose(
        reference(Backlash(3.0, 0.2, 0.4)), -1.5 * AT.at.direction * share, rtol=0, atol=1e-5
    )


def test_what_the_reference_adds() -> None:
    time_s = AT.at.time_s
    disc = Disc(orders=np.array([0, 100 * ARCSEC]))
    plain = reference(disc=disc)
    faces = np.random.default_rng(1).standard_normal(24)
    number = np.round(TARGET / (2 * np.pi / 24)).astype(int)
    for cause, expected in (
        (Creep(7.0), 7.0 * (time_s - 50.0) / 3600),
        (Faces(1.0, faces), faces[number]),
        (FirstOrderOfReference(0.4, 0.2), 0.4 * np.cos(TARGET + 0.2)),
        (GainOfReference(0.01), 0.01 * plain),
        (Line(0.3, 0.01, 0.1), 0.3 * np.cos(2 * np.pi * 0.01 * time_s + 0.1)),
        (ReferenceJump(2.0, 200.0), 2.0 * (time_s >= 200.0)),
        (
            GearError(0.5, 31.0, (0.1, 0.2)),
            0.5 * np.cos(31 * TARGET + 0.1) + 0.1 * np.cos(62 * TARGET + 0.2),
        ),
        (
            AngleLine(0.5, 31.5, 0.1, 2.0),
            0.5 * np.cos(31.5 * TARGET + np.where(AT.at.direction > 0, 0.1, 2.0)),
        ),
        (BentScale(2.0), 2.0 * ((plain / 100) ** 3 - 0.6 * plain / 100)),
    ):
        np.testing.assert_allclose(
            reference(cause, disc=disc) - plain, expected, rtol=0, atol=1e-4, err_msg=cause.name
        )


def test_a_chirp_has_the_stated_frequency_at_each_instant() -> None:
    """The number of zero crossings in the whole log equals the integral of the stated frequency,
    times two."""
    chirp = Chirp(1.0, 0.5, 0.02, 0.0)
    log = Sweep(0, 10.0, 0.0, OMEGA, np.arange(0.0, 60.0, 0.01))
    shown = Scene(Disc(), passes=[log]).channels([chirp])["reference"]
    crossings = np.count_nonzero(np.diff(np.sign(shown)))
    assert crossings == pytest.approx(2 * (0.5 * 60 + 0.02 * 60**2 / 2), abs=1)


@pytest.mark.parametrize("unwrapped", [True, False])
def test_stations_up_go_on_over_the_turn_and_come_back_from_it(unwrapped: bool) -> None:
    found = stations(np.arange(6) * (np.pi / 3), 2, not unwrapped)
    steps = np.diff(found.at.turned_rad)
    if unwrapped:
        np.testing.assert_allclose(steps, np.pi / 3)
    else:
        np.testing.assert_allclose(np.abs(steps[steps != 0]), np.pi / 3)
    assert found.at.run.tolist() == sorted(found.at.run.tolist())
