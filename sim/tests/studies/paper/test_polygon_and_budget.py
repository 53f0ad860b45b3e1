"""Tests of equations (13) to (17) of the paper against the printed values and the underlying
geometry."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.studies.paper import (
    PUBLISHED,
    UncertaintyBudget,
    bessel_deviation,
    mounting_eccentricity_rad,
    residual_orders,
    station_errors,
    tower_difference_rad,
)
from arctrue.table.instruments import Polygon

FACES = np.arange(PUBLISHED.faces)


def plain_polygon() -> Polygon:
    zero = np.zeros(PUBLISHED.faces)
    return Polygon(zero, zero, 0.0, PUBLISHED.face_width_m, 0.0, 0.0)


def test_eccentricity_and_tower_difference_are_the_printed_ones() -> None:
    """The eccentricity and the tower difference equal the printed values, which have one digit:
    0.0005 and 0.0001."""
    u4 = ARCSEC_PER_RAD * mounting_eccentricity_rad(1e-6, 0.03e-6, 10e-3)
    u5 = ARCSEC_PER_RAD * tower_difference_rad(np.deg2rad(15.0), 8.0 / ARCSEC_PER_RAD)
    assert round(u4, 4) == 0.0005
    assert round(u5, 4) == 0.0001


def test_the_budget_is_the_printed_one() -> None:
    assert round(PUBLISHED.budget.combined_arcsec, 2) == PUBLISHED.combined_arcsec
    assert round(PUBLISHED.budget.expanded_arcsec, 2) == PUBLISHED.expanded_arcsec
    assert UncertaintyBudget(3.0, 0.0, 4.0, 0.0, 0.0).expanded_arcsec == pytest.approx(10.0)


def test_deviation_is_that_of_the_standard_library() -> None:
    import statistics

    values = np.random.default_rng(3).normal(size=(10, 4))
    expected = [statistics.stdev(values[:, face]) for face in range(4)]
    np.testing.assert_allclose(bessel_deviation(values), expected, rtol=1e-12)
    with pytest.raises(ValueError, match="two cycles"):
        bessel_deviation(values[:1])


def test_a_hollow_face_met_off_its_centre_errs_by_equation_14() -> None:
    polygon = dataclasses.replace(plain_polygon(), flatness_m=0.03e-6, offset_m=1e-6)
    seen = polygon.direction_rad(FACES, np.zeros(PUBLISHED.faces))
    # The face with the largest error is exactly at 90° (face 6 of 24).
    assert np.abs(seen).max() == pytest.approx(mounting_eccentricity_rad(1e-6, 0.03e-6, 10e-3))


def test_a_leaning_face_errs_less_than_equation_15_allows() -> None:
    """A leaning face has a smaller error than equation (15) allows: near the axis of the
    autocollimator the error of the reflection is of third order."""
    tilt = np.full(PUBLISHED.faces, PUBLISHED.tilt_arcsec / ARCSEC_PER_RAD)
    polygon = dataclasses.replace(plain_polygon(), tilt_rad=tilt)
    deviation = np.full(PUBLISHED.faces, 150.0 / ARCSEC_PER_RAD)
    error = polygon.direction_rad(FACES, deviation) - deviation
    limit = tower_difference_rad(np.deg2rad(15.0), tilt[0])
    assert 0.0 < np.abs(error).max() < limit


def test_an_upright_flat_polygon_shows_where_the_table_stands() -> None:
    deviation = np.linspace(-150.0, 150.0, PUBLISHED.faces) / ARCSEC_PER_RAD
    np.testing.assert_allclose(
        plain_polygon().direction_rad(FACES, deviation), deviation, atol=1e-15
    )


def test_drawn_instruments_keep_to_table_3() -> None:
    """The sample deviation of 2,400 simulated faces equals that of table 3 within 4 of its own
    standard deviations."""
    random = np.random.default_rng(8)
    drawn = [
        ARCSEC_PER_RAD * PUBLISHED.drawn_polygon(random).direction_rad(FACES, np.zeros(24))
        for _ in range(100)
    ]
    errors = [
        ARCSEC_PER_RAD * PUBLISHED.drawn_autocollimator(0.0, random).error_rad for _ in range(100)
    ]
    tolerance = 4.0 / np.sqrt(2.0 * 2400)
    assert np.std(drawn) == pytest.approx(PUBLISHED.budget.polygon_arcsec, rel=tolerance)
    assert np.std(errors) == pytest.approx(PUBLISHED.budget.autocollimator_arcsec, rel=tolerance)


def test_station_errors_have_the_sign_of_the_table() -> None:
    """The error of a face is the negative reading of the autocollimator at this face, minus the
    mean of these values over the cycle."""
    readings = np.zeros((2, 24))
    readings[:, 5] = -24.0 / ARCSEC_PER_RAD
    errors = station_errors(readings)
    assert errors.mean_arcsec[5] == pytest.approx(23.0)
    assert errors.mean_arcsec[0] == pytest.approx(-1.0)
    assert errors.span_arcsec == pytest.approx((-1.0, 23.0))


@pytest.mark.parametrize("order", [1, 5, 11, 12])
def test_each_order_is_found_with_its_amplitude(order: int) -> None:
    angle = 2.0 * np.pi * FACES / 24
    orders = residual_orders(0.7 * np.cos(order * angle))
    expected = np.zeros(12)
    expected[order - 1] = 0.7
    np.testing.assert_allclose(orders, expected, atol=1e-12)
