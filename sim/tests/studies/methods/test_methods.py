"""Every method beside what its principle says it sees and does not see."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from arctrue.calibration.transfer_function import noise_gain, transfer_function
from arctrue.studies.methods.equal_division import equal_division
from arctrue.studies.methods.free_spin import FREE_SPIN, FreeSpin
from arctrue.studies.methods.head_places import best_third, gain_of_places
from arctrue.studies.methods.heads_least_squares import (
    MOTION_ORDERS,
    harmonics_of_heads,
    least_squares_of,
)
from arctrue.studies.methods.method import Method, of_harmonics
from arctrue.studies.methods.polygon_closure import POLYGON_CLOSURE, closure, spread_shifts
from arctrue.studies.methods.reference_table import LOOK_UP_TABLE, straight_lines
from arctrue.studies.methods.two_heads_dft import TWO_HEADS_LEAST_SQUARES
from arctrue.studies.methods.virtual_division import virtual_average
from arctrue.studies.methods.world import MethodsSettings, World

SHORT = MethodsSettings(minutes=1.0)
"""Five turns."""
NO_MOTION = np.zeros(0, dtype=np.int64)
FOUR_DEG = (0.0, 33.0, 138.5, 279.5)


@cache
def left(name: str, motion_m: float = 0.1e-6) -> np.ndarray:
    """Amplitudes of orders 1 to 128 that a method leaves."""
    method: Method = {
        "eda": equal_division(4),
        "two": TWO_HEADS_LEAST_SQUARES,
        "three": least_squares_of("three", FOUR_DEG[:3], motion=False),
        "four": least_squares_of("four", FOUR_DEG, motion=True),
        "spin": FREE_SPIN,
    }[name]
    world = World(dataclasses.replace(SHORT, radial_motion_m=motion_m))
    return world.score(method.run(world)).amplitude_arcsec


def test_four_heads_separate_the_axis_from_the_disc_and_three_do_not() -> None:
    """The motion of order 2 is 0.38″ at the disc: 0.1 µm over 53.975 mm."""
    limit = (
        6.0
        * 0.1
        * np.sqrt(2.0 / (5 * 12_000))
        * np.max(gain_of_places(-np.radians(FOUR_DEG), np.arange(1, 41), MOTION_ORDERS))
    )
    assert left("four")[:40].max() < limit
    assert left("three")[1] > 0.1
    assert left("two")[1] > 0.1
    assert left("three", 0.0)[1] < limit


def test_equal_division_leaves_the_multiples_of_its_heads_and_no_others() -> None:
    """Orders 4, 8, 12, 24 and 120 of the disc as they are: 0.7, 0.35, 0.2, 0.3, 0.2″."""
    found = left("eda")
    np.testing.assert_allclose(found[[3, 7, 11, 23, 119]], [0.7, 0.35, 0.2, 0.3, 0.2], atol=0.01)
    others = np.delete(found[:40], [3, 7, 11, 15, 19, 23, 27, 31, 35, 39])
    assert others.max() < 0.01


def test_two_heads_do_not_see_order_120() -> None:
    assert left("two", 0.0)[119] == pytest.approx(0.2, abs=0.02)
    assert left("three", 0.0)[119] < 0.01


def test_a_free_spin_sees_all_that_repeats_with_the_angle() -> None:
    assert left("spin")[:40].max() < 0.01


def test_a_spin_that_ends_is_refused() -> None:
    world = World(dataclasses.replace(SHORT, minutes=120.0))
    with pytest.raises(ValueError, match="comes to rest before 7200 s"):
        FREE_SPIN.run(world)


def test_the_spin_obeys_its_equation_of_motion() -> None:
    """The angle's second derivative by finite differences against the torques."""
    spin = FreeSpin(torque_rad_s2=(0.02, 0.005))
    time = 300.0 + np.array([-1e-3, 0.0, 1e-3])
    angle, _ = spin.angle(time)
    smooth, speed = spin.smooth(time[1:2])
    repeated = sum(
        torque * np.cos(order * smooth[0] + 0.3 * order)
        for order, torque in zip(spin.torque_orders, spin.torque_rad_s2, strict=True)
    )
    expected = -spin.coulomb_rad_s2 - spin.viscous_hz * speed[0] + repeated
    assert np.diff(angle, 2)[0] / 1e-6 == pytest.approx(expected, abs=2e-3 * abs(expected))


def test_many_heads_with_two_are_the_calibration_of_two_heads() -> None:
    """Another program for the same equations; they differ in where α's error enters."""
    world = World(SHORT)
    own = of_harmonics(*harmonics_of_heads(world, (0.0, 33.0), NO_MOTION))
    angle = np.linspace(0.0, 2.0 * np.pi, 500)
    calibrated = TWO_HEADS_LEAST_SQUARES.run(world)(angle)
    # Order 120 is a fit of 10⁴ times its noise in one and left out in the other.
    difference = own(angle) - calibrated
    phase = 120.0 * angle
    blind = np.column_stack([np.cos(phase), np.sin(phase), np.ones(angle.size)])
    difference -= blind @ np.linalg.lstsq(blind, difference)[0]
    assert np.abs(difference).max() < 2e-3


def test_gain_of_two_places_is_the_transfer_function() -> None:
    """One head's noise is 1/√2 of that of the difference that TF(n) multiplies."""
    orders = np.arange(1, 120)
    gain = gain_of_places(-np.radians([0.0, 33.0]), orders, NO_MOTION)
    expected = np.sqrt(2.0) * noise_gain(orders, np.radians(33.0))
    np.testing.assert_allclose(gain, expected, rtol=1e-9)
    assert np.isinf(gain_of_places(-np.radians([0.0, 33.0]), np.array([120]), NO_MOTION))[0]


@pytest.mark.parametrize("order", [2, 5, 8])
def test_gain_of_four_places_is_that_of_the_pseudoinverse(order: int) -> None:
    beta = -np.radians(FOUR_DEG)
    matrix = np.column_stack(
        [np.exp(-1j * order * beta), np.ones(4), np.exp(1j * beta), np.exp(-1j * beta)]
    )
    expected = np.linalg.norm(np.linalg.pinv(matrix)[0])
    found = gain_of_places(beta, np.array([order]), MOTION_ORDERS)[0]
    assert found == pytest.approx(expected, rel=1e-9)


def test_three_places_see_nothing_of_the_disc_where_the_axis_moves() -> None:
    gain = gain_of_places(-np.radians(FOUR_DEG[:3]), np.array([2, 3, 5]), MOTION_ORDERS)
    assert np.isinf(gain).all()


def test_the_best_third_head_is_the_best_of_all_places_one_by_one() -> None:
    orders = np.arange(1, 41)
    worst = {
        place: gain_of_places(-np.radians([0.0, 33.0, place]), orders, NO_MOTION).max()
        for place in np.arange(10.0, 360.0, 10.0)
    }
    found = best_third((0.0, 33.0), orders, 10.0)
    assert worst[found] == min(worst.values())


def test_virtual_heads_are_the_transfer_function_of_the_two_real_ones() -> None:
    """One equation in the angle, the other in the order; multiples of 120 are lost in both."""
    steps, separation = 1200, Fraction(33, 360)
    angle = np.arange(steps) * (2.0 * np.pi / steps)
    alpha = 2.0 * np.pi * float(separation)
    random = np.random.default_rng(2)
    orders = np.array([1, 2, 11, 109, 120, 240])
    phases = random.uniform(0.0, 2.0 * np.pi, orders.size)

    def error(at: np.ndarray) -> np.ndarray:
        return np.cos(np.multiply.outer(at, orders) + phases).sum(axis=-1)

    found = virtual_average(error(angle + alpha) - error(angle), separation)
    lines = np.fft.rfft(found) * (2.0 / steps)
    seen = transfer_function(orders, alpha) != 0.0
    assert seen.tolist() == [True, True, True, True, False, False]
    np.testing.assert_allclose(lines[orders], np.where(seen, np.exp(1j * phases), 0.0), atol=1e-9)
    with pytest.raises(ValueError, match="expected a multiple of 120"):
        virtual_average(np.zeros(1000), separation)


def test_closure_parts_table_and_polygon() -> None:
    """Drawn errors, no scatter: both come back but for their means."""
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
    """400 draws: the root mean square of (found − true)/u is 1 within 4 of its deviations."""
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
    """With faces as wrong as 2″ the closure is as good as before."""
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
    """Half way between stations at 0° and 15° the chord is A·cos² 7.5°: 1.22″ below 144″·cos."""
    station = np.arange(24) * (2.0 * np.pi / 24)
    angle = np.linspace(0.0, 2.0 * np.pi, 2000)
    gap = 144.0 * np.cos(angle) - straight_lines(station, 144.0 * np.cos(station))(angle)
    assert np.abs(gap).max() == pytest.approx(
        144.0 * np.cos(np.pi / 24) * (1.0 - np.cos(np.pi / 24)), rel=1e-3
    )
