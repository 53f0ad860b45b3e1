"""Tests of the two estimators, least squares and Fourier transform, against exactly known
errors."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from arctrue.calibration import (
    CalibrationSettings,
    Estimate,
    calibrate,
    fourier,
    least_squares,
    whole_turns,
)
from arctrue.calibration.harmonics import as_function_of_reading, error_arcsec
from arctrue.measurement import Table

from .synthetic import ARCSEC, COUNTS, Disc, capture_of, set_of, turn_angles

ALPHA = np.radians(33.0)
ORDERS = np.arange(1, 13)
DISC = Disc({1: (150.0, 0.4), 2: (0.9, 2.0), 5: (0.5, -1.0), 8: (0.3, 1.1), 11: (0.4, 0.2)})


def left_over(disc: Disc, found: Estimate, values=None) -> np.ndarray:
    """Return the error in ″ that the correction leaves at each reading, minus the mean of this
    error."""
    reading = np.arange(4096) * (2.0 * np.pi / 4096)
    true_error = (reading - disc.true_angle(reading)) / ARCSEC
    values = found.values if values is None else values
    left = true_error - error_arcsec(found.orders, values, reading)
    return left - left.mean()


def turns_of(disc: Disc, *thetas, noise: float = 0.0, seed: int = 1):
    random = np.random.default_rng(seed)
    return whole_turns(
        capture_of([disc.heads(theta, noise, random) for theta in thetas]),
        disc.counts_per_rev,
        range(len(thetas)),
        12,
    )


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("start", [0.3, -40.0, 1000.0])
def test_least_squares_is_exact_but_for_rounding(direction: int, start: float) -> None:
    turns = turns_of(DISC, turn_angles(start=start, direction=direction))
    found, warnings = least_squares(turns, COUNTS, ALPHA, ORDERS)
    # The rounding to counts adds 0.022″·√2/√6000, which order 11 magnifies 19 times.
    assert np.abs(left_over(DISC, found)).max() < 0.03
    assert not warnings


@pytest.mark.parametrize("samples", [1201, 5000, 12000])
def test_any_number_of_samples_turns_and_uneven_steps(samples: int) -> None:
    one = turn_angles(samples, 2, ripple_rad=0.002)
    other = turn_angles(samples + 311, 1, direction=-1, start=2.0, ripple_rad=0.003, ripple_order=5)
    found, _ = least_squares(turns_of(DISC, one, other), COUNTS, ALPHA, ORDERS)
    assert np.abs(left_over(DISC, found)).max() < 0.03 * np.sqrt(12000 / samples)


def test_fourier_equals_the_formula_of_the_paper() -> None:
    """For one turn from θ = 0, ``fourier`` gives the result of equations (4)–(7), which the test
    evaluates as a plain sum over the samples."""
    turns = turns_of(DISC, turn_angles(start=0.0))
    found, _ = fourier(turns, COUNTS, ALPHA, ORDERS, "nominal")
    delta = (turns[0].head2_counts - turns[0].head1_counts) * (1_296_000 / COUNTS) - 33 * 3600.0
    theta = 2.0 * np.pi * np.arange(12_000) / 12_000
    for index, order in enumerate(ORDERS.tolist()):
        coefficient = np.mean(delta * np.exp(-1j * order * theta))
        expected = coefficient / (np.exp(1j * order * ALPHA) - 1.0)
        assert 2.0 * abs(expected) == pytest.approx(found.amplitude_arcsec[index], abs=1e-3)
        # The two methods place θ = 0 differently: one uses the mean of R₁, the other the mean of θ.
        if found.amplitude_arcsec[index] > 0.2:
            assert np.angle(expected) == pytest.approx(found.phase_rad[index], abs=1e-4)


def test_fourier_takes_both_directions_and_many_turns() -> None:
    turns = turns_of(DISC, turn_angles(6000, 3), turn_angles(6000, 2, direction=-1, start=9.0))
    found, _ = fourier(turns, COUNTS, ALPHA, ORDERS)
    values = as_function_of_reading(found.orders, found.values)
    assert np.abs(left_over(DISC, found, values)).max() < 0.03


def test_error_taken_at_the_reading_leaves_second_order() -> None:
    """See docs/errata.md, "(8)": an error estimated as a function of the true angle θ leaves
    (150″)²/2 = 0.0545″ of order 2 for an eccentricity of 150″; an error estimated as a function of
    the reading R leaves none."""
    disc = Disc()
    found, _ = fourier(turns_of(disc, turn_angles()), COUNTS, ALPHA, ORDERS)
    plain = left_over(disc, found)
    second = 2.0 * abs(np.mean(plain * np.exp(-2j * np.arange(4096) * 2.0 * np.pi / 4096)))
    assert second == pytest.approx(150.0**2 / 2.0 * ARCSEC, abs=0.003)
    as_reading = as_function_of_reading(found.orders, found.values)
    # Order 11 keeps 0.005″ from the rounding to counts.
    assert np.abs(left_over(disc, found, as_reading)).max() < 0.02


def test_speed_ripple_spoils_the_transform_and_not_the_fit() -> None:
    """A ripple of the speed causes errors in the Fourier transform, but not in the fit; see
    docs/errata.md, "a DFT needs equal steps of angle". The angle has a ripple ρ = 0.002 rad of
    order 7, and the readings have 0.1″ of noise. To first order the ripple moves half of ρ·D₁,
    with the amplitude D₁ of order 1, into orders 6 and 8 of δ₂₁, that is 0.043″ and 0.057″ of ε. A
    start angle from a single sample, which is not used here, would add 0.1″."""
    disc = Disc({1: (150.0, 0.4), 2: (0.9, 2.0), 5: (0.5, -1.0)})
    orders = np.arange(1, 9)
    turns = turns_of(disc, turn_angles(ripple_rad=0.002), noise=0.1, seed=3)
    transformed, _ = fourier(turns, COUNTS, ALPHA, orders)
    fitted, _ = least_squares(turns, COUNTS, ALPHA, orders)
    values = as_function_of_reading(orders, transformed.values)
    assert transformed.amplitude_arcsec[[5, 7]] == pytest.approx([0.043, 0.057], abs=0.006)
    assert fitted.amplitude_arcsec[[5, 7]] == pytest.approx(0.0, abs=0.006)
    assert np.abs(left_over(disc, transformed, values)).max() > 0.08
    assert np.abs(left_over(disc, fitted)).max() < 0.05


@pytest.mark.parametrize("method", [fourier, least_squares])
def test_head_separation_is_measured(method) -> None:
    disc = Disc(alpha_deg=33.0 + 40.0 / 3600.0)
    found, warnings = method(turns_of(disc, turn_angles(), noise=0.1), COUNTS, ALPHA, ORDERS)
    # A mean over uniform readings, instead of uniform angles, would be wrong by (150″)²/2·sin 33° =
    # 0.03″.
    off_arcsec = (found.measured_separation_rad - np.radians(disc.alpha_deg)) / ARCSEC
    assert abs(off_arcsec) < 0.01
    assert found.head_separation_rad == found.measured_separation_rad
    # Each of the two heads contributes a rectangular distribution of ± 1 count; the noise of the
    # mean is small.
    by_index = np.sqrt(2.0 / 3.0) * 0.0772
    assert by_index < found.u_measured_separation_rad / ARCSEC < 1.1 * by_index
    assert not warnings


def test_nominal_separation_leaves_what_theory_says() -> None:
    """If α is wrong by Δ, the correction leaves |n·Δ/2·(cot(nα/2) + j)| times the amplitude of
    order n: 1.76 Δ at n = 1."""
    disc = Disc({1: (150.0, 0.4)}, alpha_deg=33.0 + 50.0 / 3600.0)
    turns = turns_of(disc, turn_angles())
    wrong, _ = least_squares(turns, COUNTS, ALPHA, np.arange(1, 6), "nominal")
    right, _ = least_squares(turns, COUNTS, ALPHA, np.arange(1, 6), "measured")
    first = 2.0 * abs(
        np.mean(left_over(disc, wrong) * np.exp(-1j * np.arange(4096) * 2 * np.pi / 4096))
    )
    assert first == pytest.approx(1.76 * 50.0 * ARCSEC * 150.0, rel=0.03)
    assert np.abs(left_over(disc, right)).max() < 0.005
    # The stated uncertainty covers this error: with u(α) = 50″/√3, order 1 of 150″ gets the
    # uncertainty 0.5·cot(α/2)·u(α)·150″ = 1.69·u(α)·150″ along its amplitude.
    expected = 0.5 / np.tan(ALPHA / 2.0) * 50.0 / np.sqrt(3.0) * ARCSEC * 150.0
    assert wrong.u_amplitude_arcsec[0] == pytest.approx(expected, rel=0.03)
    assert right.u_amplitude_arcsec[0] < 0.01


@pytest.mark.parametrize("method", [fourier, least_squares])
def test_index_that_cannot_be_believed_falls_back_to_nominal(method) -> None:
    far = Disc(alpha_deg=33.4)
    found, warnings = method(turns_of(far, turn_angles()), COUNTS, ALPHA, ORDERS)
    assert found.head_separation_rad == pytest.approx(ALPHA)
    assert any("+1440" in text and "index" in text for text in warnings)

    first, second = turn_angles(), turn_angles(start=3.0)
    heads = [DISC.heads(first), DISC.heads(second)]
    heads[1][1] += 40  # counts: head 2 detected its index at another place in the second run
    turns = whole_turns(capture_of(heads), COUNTS, None, 12)
    found, warnings = method(turns, COUNTS, ALPHA, ORDERS)
    assert found.head_separation_rad == pytest.approx(ALPHA)
    assert any("runs disagree on the head separation by 3.09" in text for text in warnings)


def test_orders_that_cannot_be_seen() -> None:
    """The estimator marks order 120, which both heads read alike at 33°, as not observable; at
    orders 11 and 109 it magnifies the noise 19 times."""
    orders = np.arange(1, 125)
    for method in (fourier, least_squares):
        found, _ = method(turns_of(DISC, turn_angles(4000)), COUNTS, ALPHA, orders)
        assert np.isinf(found.noise_gain[119])
        assert np.isinf(found.u_amplitude_arcsec[119])
        assert found.amplitude_arcsec[119] == 0.0
        assert np.isfinite(np.delete(found.noise_gain, 119)).all()
        assert found.noise_gain[[10, 108]] == pytest.approx(1.0 / 0.0523, rel=0.01)


def test_runs_that_disagree_have_the_uncertainty_of_that() -> None:
    warm = Disc({**DISC.orders, 1: (151.0, 0.4)})
    random = np.random.default_rng(4)
    heads = [d.heads(turn_angles(4000), 0.1, random) for d in (DISC, DISC, DISC, warm)]
    turns = whole_turns(capture_of(heads), COUNTS, None, 12)
    found, _ = least_squares(turns, COUNTS, ALPHA, ORDERS)
    assert found.disagreement[0] > 100.0
    assert (found.disagreement[1:] == 1.0).all()
    # One of the four values differs by 1″, so that their mean has u = 0.25″ along the amplitude. χ²
    # has 6 degrees of freedom. Three of these belong to the phases, which do not scatter, so the
    # estimated u is 0.25″/√2.
    assert found.u_amplitude_arcsec[0] == pytest.approx(0.25 / np.sqrt(2.0), rel=0.1)


def test_function_of_reading_solves_the_implicit_equation() -> None:
    orders = np.array([1, 2, 9])
    disc = Disc({1: (600.0, 0.2), 2: (40.0, 1.0), 9: (5.0, -2.0)})
    angles = np.arange(1, 40)
    values = np.zeros(78)
    for order, (amplitude, phase) in disc.orders.items():
        values[order - 1] = amplitude * np.cos(phase)
        values[39 + order - 1] = -amplitude * np.sin(phase)
    g = as_function_of_reading(angles, values)
    reading = np.linspace(-7.0, 7.0, 999)
    expected = (reading - disc.true_angle(reading)) / ARCSEC
    found = error_arcsec(angles, g, reading)
    assert found - found.mean() == pytest.approx(expected - expected.mean(), abs=0.02)
    apart = (found - expected) - (found - expected).mean()
    assert np.abs(apart).max() < 1e-6
    assert orders.size == len(disc.orders)


@pytest.mark.parametrize("method", ["fourier", "least_squares"])
def test_two_heads_given_by_their_places_are_the_same_to_the_bit(
    method: Literal["fourier", "least_squares"],
) -> None:
    disc = Disc({1: (150.0, 0.4), 3: (2.0, 1.0)})
    capture = capture_of([disc.heads(turn_angles(3000), 0.1, np.random.default_rng(1))])
    by_separation = set_of(disc, capture)
    by_places = replace(
        by_separation,
        table=Table(counts_per_rev=disc.counts_per_rev, head_places_deg=(0.0, 33.0)),
    )
    settings = CalibrationSettings(method=method, most_order=8)
    one, other = (calibrate(item, settings) for item in (by_separation, by_places))
    np.testing.assert_array_equal(one.estimate.values, other.estimate.values)
    np.testing.assert_array_equal(one.estimate.covariance, other.estimate.covariance)
    assert one.coefficients == other.coefficients


def test_a_line_of_a_quiet_run_has_its_amplitude() -> None:
    """A line of 0.1″ in the quietest of three runs is reported with 0.1″; the noise of the other
    runs does not scale it.

    The bound is 4 standard deviations of the amplitude of a line in 12,000 samples, with the noise
    of two heads.
    """
    theta, random, noise = turn_angles(), np.random.default_rng(4), 0.05
    disc = Disc({1: (50.0, 0.0)})
    runs = [disc.heads(theta, size, random) for size in (noise, 0.4, 0.4)]
    line = 0.1 * np.cos(100.0 * theta) * ARCSEC * COUNTS / (2.0 * np.pi)
    runs[0][1] += np.rint(line).astype(np.int64)
    found = calibrate(set_of(disc, capture_of(runs))).estimate.residual_peaks
    assert [round(order) for order, _ in found] == [100]
    # Rounding to whole counts of 0.077″ changes the amplitude of the line, so the rounded line
    # gives the expected amplitude.
    rounded = 2.0 * np.mean(np.rint(line) * np.cos(100.0 * theta)) * 1_296_000 / COUNTS
    bound = 4.0 * noise * np.sqrt(2.0) * np.sqrt(2.0 / theta.size)
    assert found[0][1] == pytest.approx(rounded, abs=bound)
