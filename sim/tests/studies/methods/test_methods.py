"""Tests, for every method, that the method determines exactly the errors that its principle can
determine."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from arctrue.calibration.heads_gain import order_gain
from arctrue.calibration.transfer_function import noise_gain, transfer_function
from arctrue.studies.methods.equal_division import equal_division
from arctrue.studies.methods.free_spin import FREE_SPIN, FreeSpin, timed_lines
from arctrue.studies.methods.heads_least_squares import (
    calibrated_mean_of,
    least_squares_of,
    mean_of,
)
from arctrue.studies.methods.method import Method
from arctrue.studies.methods.polygon_closure import POLYGON_CLOSURE, closure, spread_shifts
from arctrue.studies.methods.reference_table import LOOK_UP_TABLE, straight_lines
from arctrue.studies.methods.two_heads_dft import TWO_HEADS_LEAST_SQUARES
from arctrue.studies.methods.world import MethodsSettings, World
from arctrue.studies.stop_and_go.servo import Axis

SHORT = MethodsSettings(minutes=1.0)
"""Settings of a measurement over five turns."""
FOUR_DEG = (0.0, 33.0, 138.5, 279.5)
MOTION_ORDERS = tuple(range(2, 9))


@cache
def left(name: str, motion_m: float = 0.1e-6) -> np.ndarray:
    """Return the amplitudes in arcseconds of orders 1 to 128 that remain after a method."""
    method: Method = {
        "eda": equal_division(4),
        "two": TWO_HEADS_LEAST_SQUARES,
        "three": least_squares_of("three", FOUR_DEG[:3], ()),
        "four": least_squares_of("four", FOUR_DEG, MOTION_ORDERS),
        "spin": FREE_SPIN,
    }[name]
    world = World(dataclasses.replace(SHORT, radial_motion_m=motion_m))
    return world.score(method.run(world)).amplitude_arcsec


@pytest.mark.large
def test_four_heads_separate_the_axis_from_the_disc_and_three_do_not() -> None:
    """Four heads separate the axis motion of order 2 from the disc, and three do not; the motion is
    0.1 µm, which is 0.38″ at the radius of 53.975 mm."""
    limit = (
        6.0
        * 0.1
        * np.sqrt(2.0 / (5 * 12_000))
        * np.max(order_gain(np.radians(FOUR_DEG), np.arange(1, 41), MOTION_ORDERS))
    )
    assert left("four")[:40].max() < limit
    assert left("three")[1] > 0.1
    assert left("two")[1] > 0.1
    assert left("three", 0.0)[1] < limit


def test_equal_division_leaves_the_multiples_of_its_heads_and_no_others() -> None:
    """The mean of four heads leaves the orders 4, 8, 12, 24 and 120 of the disc unchanged, which
    have 0.7, 0.35, 0.2, 0.3 and 0.2″."""
    found = left("eda")
    np.testing.assert_allclose(found[[3, 7, 11, 23, 119]], [0.7, 0.35, 0.2, 0.3, 0.2], atol=0.01)
    others = np.delete(found[:40], [3, 7, 11, 15, 19, 23, 27, 31, 35, 39])
    assert others.max() < 0.01


def test_two_heads_do_not_see_order_120() -> None:
    assert left("two", 0.0)[119] == pytest.approx(0.2, abs=0.02)
    assert left("three", 0.0)[119] < 0.01


def test_a_free_spin_sees_all_but_the_torque_that_is_not_fitted() -> None:
    """A free spin finds all orders except the torque's order 5, which is not fitted. This torque,
    10⁻⁴ of the friction, changes the angle by τ/(n²ω²) at speeds of 40 to 63 rad/s."""
    found = left("spin")[:40]
    spin = FreeSpin()
    swing = spin.torque_rad_s2[2] / (5 * np.array([63.0, 40.0])) ** 2 * 206265.0
    assert found[4] < 1.5 * swing[1]
    # In 15 spins of two turns, noise of 0.1″ per line leaves 0.02″ in the orders that resemble the
    # free response.
    assert np.delete(found, 4).max() < 0.12


def test_a_spin_that_ends_is_refused() -> None:
    """A table that starts at 10 turns per second stops after 3.1 turns, with the friction of the
    study stop_and_go; the method must refuse a spin of three turns."""
    with pytest.raises(ValueError, match=r"comes to rest after 3.1 turns, a spin of 3 was"):
        timed_lines(World(SHORT), FreeSpin(turns_a_spin=3))


def test_the_spin_has_the_friction_of_stop_and_go() -> None:
    """The free spin has the friction of the study stop_and_go: the axis of that study is released
    at 20 rad/s, and the free response equals a stepwise solution of LuGre's model."""
    axis, step_s = Axis(), 1e-5
    speed, bend, gone = np.array([20.0]), np.array([0.0]), 0.0
    for _ in range(20_000):
        torque, bend = axis.friction(speed, bend, step_s)
        speed = speed - torque / axis.inertia_kg_m2 * step_s
        gone += step_s
    _, expected = FreeSpin(start_rad_s=20.0).smooth(np.array([gone]))
    # The bristles bend only in the first 100 µrad, which take 5 µs; an Euler step errs by 2.5 Hz·10
    # µs.
    assert speed[0] == pytest.approx(expected[0], abs=0.01)


def test_the_spin_obeys_its_equation_of_motion() -> None:
    """The spin obeys its equation of motion: the second derivative of the angle, by finite
    differences, equals the sum of the torques.

    The speed falls during a turn, while τ/(n²ω²) is exact only for a constant speed: the test
    allows a fifth of the sum of the repeated torques.
    """
    spin = FreeSpin(torque_orders=(1, 2), torque_shares=(0.02, 0.005))
    time = 0.1 + np.array([-1e-3, 0.0, 1e-3])
    angle, _ = spin.angle(time)
    smooth, speed = spin.smooth(time[1:2])
    repeated = sum(
        torque * np.cos(order * smooth[0] + 0.3 * order)
        for order, torque in zip(spin.torque_orders, spin.torque_rad_s2, strict=True)
    )
    without = -spin.coulomb_rad_s2 - spin.viscous_hz * speed[0]
    largest = sum(spin.torque_rad_s2)
    found = np.diff(angle, 2)[0] / 1e-6 - without
    assert found == pytest.approx(repeated, abs=0.2 * largest)


def test_means_keep_what_the_heads_see_equally_of_the_disc() -> None:
    """The mean of heads at 180° keeps the even orders of the disc, and the mean of heads at 120°
    keeps the multiples of three. These orders keep their amplitude; all others disappear."""
    world = World(dataclasses.replace(SHORT, radial_motion_m=0.0))
    disc = world.score(None).amplitude_arcsec
    for heads in (2, 3):
        places = tuple(360.0 * k / heads for k in range(heads))
        found = world.score(mean_of("mean", places, "").run(world)).amplitude_arcsec
        kept = np.arange(1, 129) % heads == 0
        # If heads are 50″ off their places, the share 2.4e-4·n of order n passes into the mean, and
        # order 2 changes order 1.
        np.testing.assert_allclose(found[kept][1:], disc[kept][1:], atol=0.05)
        assert found[~kept].max() < 0.1


@pytest.mark.large
def test_a_calibrated_mean_stays_where_the_axis_moves_otherwise() -> None:
    world = World(MethodsSettings.compared(minutes=1.0))
    output = calibrated_mean_of("four", (0.0, 64.3, 177.0, 257.9), "every").run(world)
    score, later = world.score(output), world.score(output, later=True)
    # Orders 47 and 77 of the disc are not fitted; in five turns the noise has gains of up to 2.7.
    assert score.edges_rms_arcsec < 0.05
    # The shift of the disc by 2 µm and the motion of the balls change the reading of a head by
    # 8.6″. The mean changes only by the slope of its correction and of the disc's error.
    assert abs(later.edges_rms_arcsec - score.edges_rms_arcsec) < 0.005
    alone = TWO_HEADS_LEAST_SQUARES.run(world)
    assert world.score(alone, later=True).edges_rms_arcsec > 0.5


def test_gain_of_two_places_is_the_transfer_function() -> None:
    """The gain of two places is the transfer function: the noise of one head is 1/√2 of that of the
    difference of two heads, which TF(n) multiplies."""
    orders = np.arange(1, 120)
    gain = order_gain(np.radians([0.0, 33.0]), orders)
    expected = np.sqrt(2.0) * noise_gain(orders, np.radians(33.0))
    np.testing.assert_allclose(gain, expected, rtol=1e-9)
    assert np.isinf(order_gain(np.radians([0.0, 33.0]), np.array([120])))[0]


@pytest.mark.parametrize("order", [2, 5, 8])
def test_gain_of_four_places_is_that_of_the_pseudoinverse(order: int) -> None:
    places = np.radians(FOUR_DEG)
    matrix = np.column_stack(
        [np.exp(1j * order * places), np.ones(4), np.exp(1j * places), np.exp(-1j * places)]
    )
    expected = np.linalg.norm(np.linalg.pinv(matrix)[0])
    found = order_gain(places, np.array([order]), MOTION_ORDERS)[0]
    assert found == pytest.approx(expected, rel=1e-9)


def test_three_places_see_nothing_of_the_disc_where_the_axis_moves() -> None:
    gain = order_gain(np.radians(FOUR_DEG[:3]), np.array([2, 3, 5]), MOTION_ORDERS)
    assert np.isinf(gain).all()


def test_virtual_heads_are_the_transfer_function_of_the_two_real_ones() -> None:
    """The virtual heads of VEDA give the same result as the transfer function of the two real
    heads. The paper describes a virtual head as a sum of δ over k steps of α.

    The mean over all 120 heads of 33° = 11/120 turn is −ε without the multiples of 120. As the page
    states, this equals the transfer function of the nominal α.
    """
    steps, separation = 1200, Fraction(33, 360)
    angle = np.arange(steps) * (2.0 * np.pi / steps)
    alpha = 2.0 * np.pi * float(separation)
    random = np.random.default_rng(2)
    orders = np.array([1, 2, 11, 109, 120, 240])
    phases = random.uniform(0.0, 2.0 * np.pi, orders.size)

    def error(at: np.ndarray) -> np.ndarray:
        return np.cos(np.multiply.outer(at, orders) + phases).sum(axis=-1)

    difference = error(angle + alpha) - error(angle)
    heads = separation.denominator
    step = steps * separation.numerator // heads
    at = (np.arange(steps) + step * np.arange(heads)[:, None]) % steps
    virtual = -np.cumsum(difference[at], axis=0)[:-1].sum(axis=0) / heads
    lines = np.fft.rfft(virtual) * (2.0 / steps)
    of_transfer = np.fft.rfft(difference)[orders] * (2.0 / steps) * transfer_function(orders, alpha)
    seen = transfer_function(orders, alpha) != 0.0
    assert seen.tolist() == [True, True, True, True, False, False]
    np.testing.assert_allclose(lines[orders], of_transfer, atol=1e-11)
    np.testing.assert_allclose(lines[orders], np.where(seen, np.exp(1j * phases), 0.0), atol=1e-9)


def test_closure_parts_table_and_polygon() -> None:
    """The closure returns the errors of polygon and table, each minus its mean, for random errors
    without scatter."""
    random = np.random.default_rng(5)
    table, faces = random.normal(size=24), random.normal(size=24)
    shifts = spread_shifts(10, 24)
    face = np.array([(np.arange(24) - shift) % 24 for shift in shifts])
    observed = table + faces[face] + random.normal(size=(10, 1))
    found = closure(observed, face)
    np.testing.assert_allclose(found.table_arcsec, table - table.mean(), atol=1e-10)
    np.testing.assert_allclose(found.faces_arcsec, faces - faces.mean(), atol=1e-10)
    assert found.degrees_of_freedom == 240 - 24 - 24 - 10 + 2


def test_the_uncertainty_of_a_closure_covers_its_error() -> None:
    """The stated uncertainty covers the error of a closure: over 400 draws, the RMS of (found −
    true)/u is 1 within 4 of its standard deviations."""
    random = np.random.default_rng(6)
    face = np.array([(np.arange(24) - shift) % 24 for shift in spread_shifts(10, 24)])
    ratios = []
    for _ in range(400):
        found = closure(random.normal(0.0, 0.08, (10, 24)), face)
        ratios.append(found.table_arcsec[0] / found.u_table_arcsec[0])
    assert np.sqrt(np.mean(np.square(ratios))) == pytest.approx(1.0, abs=4.0 / np.sqrt(800.0))


def test_one_position_of_the_polygon_is_refused() -> None:
    with pytest.raises(ValueError, match="do not separate its faces"):
        closure(np.zeros((3, 24)), np.tile(np.arange(24), (3, 1)))


def test_closure_does_not_need_the_certificate_and_the_table_does() -> None:
    """The closure does not need the certificate of the polygon: its faces have errors of 2″ here,
    and the closure is as accurate as with a good polygon."""
    world = World(dataclasses.replace(SHORT, minutes=16.0))
    polygon, autocollimator = world.instruments()
    wrong = dataclasses.replace(
        polygon, normal_rad=np.radians(np.random.default_rng(1).normal(0.0, 2.0, 24) / 3600.0)
    )

    class Worse(World):
        def instruments(self):  # type: ignore[no-untyped-def]
            return wrong, autocollimator

    worse = Worse(world.settings)
    assert worse.score(POLYGON_CLOSURE.run(worse)).edges_rms_arcsec == pytest.approx(
        world.score(POLYGON_CLOSURE.run(world)).edges_rms_arcsec, abs=1e-3
    )
    assert worse.score(LOOK_UP_TABLE.run(worse)).edges_rms_arcsec > 1.0


def test_straight_lines_between_24_stations_leave_a_part_of_order_1() -> None:
    """Straight lines between 24 stations leave a part of order 1: half way between the stations at
    0° and 15°, the chord has the height A·cos² 7.5°, which is 1.22″ below 144″·cos."""
    station = np.arange(24) * (2.0 * np.pi / 24)
    angle = np.linspace(0.0, 2.0 * np.pi, 2000)
    gap = 144.0 * np.cos(angle) - straight_lines(station, 144.0 * np.cos(station))(angle)
    assert np.abs(gap).max() == pytest.approx(
        144.0 * np.cos(np.pi / 24) * (1.0 - np.cos(np.pi / 24)), rel=1e-3
    )
