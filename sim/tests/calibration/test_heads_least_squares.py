"""Tests of the calibration of two to four heads; the readings come from a formula in this
module."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

import arctrue.calibration.heads_least_squares as module
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.heads_data import HeadsSettings
from arctrue.calibration.heads_estimate import HeadsEstimate
from arctrue.calibration.heads_gain import MotionOrders, order_gain
from arctrue.calibration.heads_least_squares import SingularHeadsError, heads_least_squares
from arctrue.calibration.least_squares import least_squares

from .synthetic import ARCSEC, COUNTS, turn_angles

Float = NDArray[np.float64]

PLACES_DEG = (0.0, 33.0, 162.5, 300.5)
DISC = {1: (150.0, 0.4), 2: (4.0, 1.0), 3: (1.5, -2.0), 5: (0.4, 0.2), 7: (0.3, 2.2)}
ORDERS = np.arange(1, 9)
PULL = 5.0
"""Largest accepted deviation in standard uncertainties. A test compares about 40 values; one of
them exceeds the limit by chance with a probability of 2e-5."""
Motion = Mapping[tuple[int, int], complex]
"""Circular motions of the axis in arcseconds, keyed by order and sense of rotation."""


def readings(
    angle: Float,
    places_rad: Float,
    *,
    motion: Motion | None = None,
    ratios: Sequence[float] = (1.0, 1.0, 1.0, 1.0),
    late_arcsec: Sequence[float] = (0.0, 0.0, 0.0, 0.0),
    moved_arcsec: Float | complex = 0.0,
    disc: Mapping[int, tuple[float, float]] = DISC,
) -> Float:
    """Return the reading θ + p + ε(θ + p) + Im(c·e^{jp}) of each head, minus the angle by which it
    detects the index mark late; rad, shape (heads, n)."""
    c = np.zeros(angle.size, dtype=complex) + moved_arcsec
    for (order, sense), value in (motion or {}).items():
        c += value * np.exp(1j * sense * order * angle)
    shown = []
    for place, ratio, late in zip(places_rad, ratios, late_arcsec, strict=False):
        error = ratio * np.imag(c * np.exp(1j * place))
        for order, (amplitude, phase) in disc.items():
            own = amplitude * (ratio if order == 1 else 1.0)
            error = error + own * np.cos(order * (angle + place) + phase)
        shown.append(angle + place + (error - late) * ARCSEC)
    return np.array(shown)


def captured(shown: Float, noise_arcsec: float, seed: int, turns: int = 1) -> WholeTurns:
    random = np.random.default_rng(seed)
    noisy = shown + random.normal(0.0, noise_arcsec * ARCSEC, shown.shape)
    counts = np.rint(noisy * (COUNTS / (2.0 * np.pi))).astype(np.int64)
    step = COUNTS * turns / shown.shape[1]
    return WholeTurns(0, turns, counts[0], counts[1], step, 0, tuple(counts[2:]))


def true_reading_values(disc: Mapping[int, tuple[float, float]] = DISC) -> Float:
    """Return the harmonics of ε as a function of the reading, found by iteration at evenly spaced
    readings."""
    reading = np.arange(1024) * (2.0 * np.pi / 1024)
    error = np.zeros_like(reading)
    for _ in range(30):
        angle = reading - error * ARCSEC
        error = sum((a * np.cos(n * angle + p) for n, (a, p) in disc.items()), np.zeros(1024))
    lines = np.fft.rfft(error) / 512
    return np.concatenate((lines.real[ORDERS], -lines.imag[ORDERS]))


def fit(part: WholeTurns, heads: int, motion: MotionOrders = (), **known: float) -> HeadsEstimate:
    given = {"u_place_arcsec": 30.0, "u_index_arcsec": 30.0, "u_radius": 0.0} | known
    settings = HeadsSettings(orders=ORDERS, motion=motion, **given)
    return heads_least_squares([part], COUNTS, np.radians(PLACES_DEG[:heads]).tolist(), settings)


def disc_pulls(found: HeadsEstimate) -> Float:
    at = np.isin(ORDERS, found.orders)
    wanted = true_reading_values()[np.tile(at, 2)]
    return np.asarray((found.values - wanted) / np.sqrt(np.diag(found.disc_covariance)))


ANGLE = turn_angles(6000, ripple_rad=0.002)


@pytest.mark.parametrize("heads", [2, 3, 4])
def test_disc_places_and_offsets_come_out_within_their_uncertainty(heads: int) -> None:
    off, late = (
        np.array([0.0, 20.0, -35.0, 10.0])[:heads],
        np.array([0.0, -15.0, 40.0, 8.0])[:heads],
    )
    places = np.radians(PLACES_DEG[:heads]) + off * ARCSEC
    found = fit(captured(readings(ANGLE, places, late_arcsec=late), 0.1, heads), heads)
    assert np.max(np.abs(disc_pulls(found))) < PULL
    np.testing.assert_allclose(
        (found.offsets_rad - places) / ARCSEC, -late, atol=PULL * 0.1 * np.sqrt(2.0 / 6000) + 0.08
    )  # 0.08″: rounding to counts of 0.077″
    pulls = (found.places_rad - places)[1:] / ARCSEC / found.u_places_arcsec[1:]
    assert np.max(np.abs(pulls)) < PULL


def test_two_heads_find_what_the_calibration_of_two_heads_finds() -> None:
    part = captured(readings(ANGLE, np.radians(PLACES_DEG[:2])), 0.1, 1)
    two, _ = least_squares([part], COUNTS, np.radians(33.0), ORDERS, "nominal")
    found = fit(part, 2, u_place_arcsec=0.0)
    same = 1e-3 * two.u_component_arcsec.min()
    np.testing.assert_allclose(found.values, two.values, atol=same)
    # One method assumes that α is known; the other estimates α with ± 29″. The test compares the
    # orders at which α adds little uncertainty.
    quiet = np.flatnonzero(ORDERS > 3)
    u = np.sqrt(np.diag(found.disc_covariance)[quiet])
    np.testing.assert_allclose(u, two.u_component_arcsec[quiet], rtol=0.25)


@pytest.mark.parametrize("senses", [(1, -1), (1,), (-1,)])
def test_four_heads_tell_the_axis_from_the_disc(senses: tuple[int, ...]) -> None:
    motion = {(2, s): 0.4 * np.exp(1j * s) for s in senses} | {(3, s): 0.2j for s in senses}
    if -1 in senses:
        motion[1, -1] = 0.5 + 0.1j
    part = captured(readings(ANGLE, np.radians(PLACES_DEG), motion=motion), 0.1, 5)
    found = fit(part, 4, (1, 2, 3))
    assert np.max(np.abs(disc_pulls(found))) < PULL
    assert [(m.order, m.sense) for m in found.axis_motion] == [
        (1, -1), (2, 1), (2, -1), (3, 1), (3, -1)
    ]  # fmt: skip
    for circle in found.axis_motion:
        apart = circle.value_arcsec - motion.get((circle.order, circle.sense), 0.0)
        assert abs(apart) < PULL * circle.u_arcsec


def test_a_forward_circle_of_order_1_is_an_eccentric_disc_and_a_backward_one_is_not() -> None:
    places = np.radians(PLACES_DEG)
    size = 0.4
    for sense, reported in ((1, False), (-1, True)):
        part = captured(readings(ANGLE, places, motion={(1, sense): size}), 0.0, 1)
        plain, allowed = fit(part, 4, u_place_arcsec=1e-3), fit(part, 4, (1,), u_place_arcsec=1e-3)
        left = [float(np.linalg.norm(disc_pulls(one)[1:8])) for one in (plain, allowed)]
        wrong = np.hypot(*np.split(plain.values - true_reading_values(), 2))[0]
        if reported:
            # The fit without the axis' circle attributes a part of the circle to the disc; the fit
            # with the circle does not.
            assert 0.1 * size < wrong < size
            assert np.hypot(*np.split(allowed.values - true_reading_values(), 2))[0] < 0.01 * size
        else:
            # Both fits assign the whole circle, Im(F·e^{jx}) with the amplitude F, to the disc.
            assert wrong == pytest.approx(size, rel=0.01)
        assert np.isfinite(left).all()


def test_motion_at_every_order_and_balls_leave_the_parity_alone() -> None:
    random = np.random.default_rng(3)
    motion = {
        (k, s): 0.3 * np.exp(2j * np.pi * random.uniform()) for k in range(2, 20) for s in (1, -1)
    }
    balls = 1.0 * np.exp(4.37j * ANGLE)
    shown = readings(ANGLE, np.radians(PLACES_DEG), motion=motion, moved_arcsec=balls)
    part = captured(shown, 0.1, 6)
    found = fit(part, 4, "every")
    pulls = np.abs(disc_pulls(found)).reshape(2, -1)
    assert np.max(pulls[:, 1:]) < PULL  # without order 1, which contains the forward circle
    # Noise of 0.1″ and the rounding to counts of 0.077″ give √(0.1² + 0.077²/12)″.
    assert found.noise_arcsec == pytest.approx(0.1025, rel=0.05)
    wrong = [
        np.max(np.abs(one.values - true_reading_values()).reshape(2, -1)[:, 1:])
        for one in (found, fit(part, 4))
    ]
    # The fit without columns for the motion assigns the motion to the disc.
    assert wrong[1] > 10.0 * wrong[0]


def test_radii_are_found_where_the_axis_is_at_rest() -> None:
    ratios = (1.0, 1.0018, 0.9985, 1.0007)
    part = captured(readings(ANGLE, np.radians(PLACES_DEG), ratios=ratios), 0.1, 8)
    found = fit(part, 4, u_radius=1e-3)
    pulls = (found.radius_ratios - ratios)[1:] / found.u_radius_ratios[1:]
    assert np.max(np.abs(pulls)) < PULL
    assert np.max(found.u_radius_ratios) < 3e-4


def test_places_are_found_where_the_axis_is_at_rest() -> None:
    off = np.array([0.0, 30.0, -45.0, 25.0])
    part = captured(readings(ANGLE, np.radians(PLACES_DEG) + off * ARCSEC), 0.1, 9)
    found = fit(part, 4, u_place_arcsec=np.inf)
    apart = (found.places_rad - np.radians(PLACES_DEG)) / ARCSEC - off
    assert np.max(np.abs(apart[1:] / found.u_places_arcsec[1:])) < PULL
    # The uncertainty of 3 to 4″ with 12,000 samples becomes 4 to 6″ with 6,000 samples.
    assert np.all((found.u_places_arcsec[1:] > 3.0) & (found.u_places_arcsec[1:] < 8.0))


def test_uncertainties_are_those_of_repeats() -> None:
    angle = turn_angles(1500)
    motion = {(2, 1): 0.4, (2, -1): 0.2j, (1, -1): 0.3}
    shown = readings(angle, np.radians(PLACES_DEG), motion=motion)
    draws = [
        fit(captured(shown, 0.3, seed), 4, (1, 2), u_place_arcsec=1e-3, u_radius=0.0)
        for seed in range(60)
    ]
    layout = draws[0].state.layout
    columns = np.arange(layout.late.start)
    found = np.array([one.state.values[columns] for one in draws])
    stated = np.array([np.diag(one.covariance)[columns] for one in draws]).mean(axis=0)
    share = found.var(axis=0, ddof=1) / stated
    # A variance from 60 draws has the relative scatter √(2/59) = 0.18. All 22 columns must lie
    # within four times this, and their mean within 4·0.18/√22 plus 0.1, because 96 lines of the
    # spectrum determine the noise near each order only to 5 %.
    assert np.all((share > 1.0 - 4 * 0.18) & (share < 1.0 + 4 * 0.18))
    assert share.mean() == pytest.approx(1.0, abs=4 * 0.18 / np.sqrt(columns.size) + 0.1)


@pytest.mark.parametrize("motion", [(), (2, 3), "every"])
def test_the_gain_of_an_order_is_its_uncertainty_over_that_of_a_line(motion: MotionOrders) -> None:
    shown = readings(ANGLE, np.radians(PLACES_DEG), disc={2: (1.0, 0.0)})
    found = fit(captured(shown, 0.5, 4), 4, motion, u_place_arcsec=1e-3)
    u = np.sqrt(np.diag(found.disc_covariance).reshape(2, -1).mean(axis=0))
    line = found.noise_arcsec * np.sqrt(2.0 / 6000)
    gain = order_gain(np.radians(PLACES_DEG), found.orders, motion)
    seen = np.isfinite(gain)
    # 96 lines of the spectrum determine the noise: u is known to 5 %, and the bound is four times
    # this.
    np.testing.assert_allclose((u / line)[seen], gain[seen], rtol=0.2)


def test_gains_of_four_heads_with_motion_unknown_at_every_order() -> None:
    orders = np.arange(2, 129)
    gain = order_gain(np.radians(PLACES_DEG), orders, "every")
    assert (round(gain.max(), 1), orders[gain.argmax()]) == (11.2, 55)
    spare = order_gain(np.radians([0.0, 64.3, 177.0, 257.9]), orders, "every")
    assert round(spare[:63].max(), 1) == 2.7
    assert orders[spare.argmax()] == 67
    # At order 1 the readings distinguish only the backward circle from the disc; the forward circle
    # has the same readings as the disc.
    assert order_gain(np.radians(PLACES_DEG), [1], "every")[0] < 1.0
    assert np.isinf(order_gain(np.radians(PLACES_DEG[:3]), [2], (2,))[0])


@pytest.mark.parametrize(
    ("heads", "motion", "known", "said"),
    [
        (3, "every", {}, "3 heads cannot separate the disc from a motion"),
        (4, "every", {"u_place_arcsec": np.inf}, "places of the heads cannot be determined"),
        (
            4,
            tuple(range(1, 9)),
            {"u_place_arcsec": np.inf},
            "4 heads do not determine the place of head 3",
        ),
        (2, (2,), {"u_place_arcsec": np.inf}, "two heads cannot separate a motion"),
    ],
)
def test_what_the_heads_do_not_determine_is_refused(
    heads: int, motion: MotionOrders, known: dict[str, float], said: str
) -> None:
    part = captured(readings(ANGLE, np.radians(PLACES_DEG[:heads])), 0.1, 2)
    with pytest.raises(SingularHeadsError, match=said):
        fit(part, heads, motion, **known)


def test_three_heads_with_motion_leave_out_the_orders_that_it_hides() -> None:
    part = captured(readings(ANGLE, np.radians(PLACES_DEG[:3]), motion={(2, 1): 0.3}), 0.1, 3)
    found = fit(part, 3, (2,), u_place_arcsec=1e-3)
    assert found.unseen_orders.tolist() == [2]
    assert np.max(np.abs(disc_pulls(found))) < PULL


@pytest.mark.parametrize("motion", [(1, 2, 3), "every"])
def test_a_search_in_a_part_of_the_samples_changes_nothing(
    motion: MotionOrders, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown = readings(ANGLE, np.radians(PLACES_DEG), motion={(2, 1): 0.4, (2, -1): 0.2j})
    part = captured(shown, 0.1, 12)
    whole = fit(part, 4, motion)
    monkeypatch.setattr(module, "SEARCH_SAMPLES", 1500)
    searched = fit(part, 4, motion)
    u = np.sqrt(np.diag(whole.disc_covariance))
    # In the search, only a quarter of the samples determines the weights and order 1; therefore the
    # test does not compare order 1.
    away = np.abs(searched.values - whole.values) / u
    assert np.max(np.delete(away, [0, ORDERS.size])) < 0.5
    assert np.max(np.abs(disc_pulls(searched)).reshape(2, -1)[:, 1:]) < PULL
