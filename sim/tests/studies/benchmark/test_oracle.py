"""Tests of the oracle, the ideal test of a set, against dense linear algebra and against simulated
draws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.measurement import Capture, MeasurementSet, Table
from arctrue.studies.benchmark.oracle import (
    FALSE_ALARM,
    POWER,
    inverse_times,
    look,
    needed_noncentrality,
)
from arctrue.studies.simulate.experiment import full
from arctrue.studies.simulate.measured_table import TrueNoise
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from arctrue.table.noise import Noise, together
from arctrue.table.registry import NOISES, REGISTRY

COUNTS = 1 << 24
DRAWS = 40
AIR = Wanted("ornstein_uhlenbeck", 0.1)


def noise(rows: int) -> Noise:
    time_s = np.arange(rows) * 0.1
    relaxing = Noise.relaxing(np.array([1.0, 0.5, 2.0]), np.array([0.3, 5.0, 400.0]), time_s)
    return together([Noise.white(np.linspace(0.2, 0.6, rows), rows), relaxing], rows)


def test_banded_inverse_is_that_of_the_full_covariance() -> None:
    process = noise(60)
    columns = np.random.default_rng(1).normal(size=(60, 4))
    expected = np.linalg.solve(process.covariance(), columns)
    np.testing.assert_allclose(inverse_times(process, columns), expected, rtol=1e-7, atol=1e-9)


def test_white_inverse_is_the_weights() -> None:
    found = inverse_times(Noise.white(0.5, 3), np.ones((3, 1)))
    np.testing.assert_allclose(found, 4.0)


@pytest.mark.parametrize("index_variance", [0.0, 0.25])
def test_noncentrality_is_that_of_generalised_least_squares(index_variance: float) -> None:
    rows = 240
    run = np.repeat([0, 1], rows // 2)
    turn = np.linspace(0.0, 2.0, rows)
    counts = np.round(turn * COUNTS).astype(np.int64)
    capture = Capture(run, np.arange(rows) * 0.1, counts, counts)
    table = Table(COUNTS, 16384, 107.95, 33.0)
    measurement = MeasurementSet(table, capture, None, "")
    process = noise(rows)
    signal = np.cos(0.37 * turn) + (run == 1) * 0.8
    in_radians = Noise(
        process.white_rad * RAD_PER_ARCSEC, process.sigma_rad * RAD_PER_ARCSEC, process.decay
    )
    found = look(
        "hysteresis",
        measurement,
        {"capture": signal},
        {"capture": TrueNoise(in_radians, np.zeros(rows, dtype=bool))},
        index_variance,
    )
    # The marginal covariance contains the variance of the offsets; the amplitudes of the orders are
    # free parameters.
    covariance = process.covariance() + index_variance * (run[:, None] == run)
    angle = 2 * np.pi * turn
    alpha = np.deg2rad(33.0)
    orders = np.arange(1, 21)
    waves = np.exp(1j * orders * (angle[:, None] + alpha)) - np.exp(1j * orders * angle[:, None])
    base = np.hstack([waves.real, waves.imag])
    inverse = np.linalg.inv(covariance)
    normal = base.T @ inverse @ base
    projected = signal - base @ np.linalg.lstsq(normal, base.T @ inverse @ signal, rcond=1e-12)[0]
    assert found.noncentrality == pytest.approx(projected @ inverse @ projected, rel=1e-4)


def test_oracle_of_four_heads_is_that_of_the_readings_of_all_heads() -> None:
    """The oracle fits three combinations of the heads. The expected value comes from the readings
    of all four heads, in which the angle of the table is unknown in every row."""
    rows, sigma, index_sigma = 90, 0.2, 0.3
    random = np.random.default_rng(5)
    run = np.repeat([0, 1, 2], rows // 3)
    turn = np.linspace(0.0, 3.0, rows)
    places = (0.0, 33.0, 160.0, 300.0)
    counts = [np.round((turn + place / 360) * COUNTS).astype(np.int64) for place in places]
    first, second, third, fourth = counts
    capture = Capture(
        run, np.arange(rows) * 0.1, first, second, head3_counts=third, head4_counts=fourth
    )
    table = Table(COUNTS, 16384, 107.95, head_places_deg=places)
    measurement = MeasurementSet(table, capture, None, "")
    signal = random.normal(size=(4, rows))
    contrasts = [
        signal[1] - signal[0],
        np.sqrt(4 / 3) * (signal[2] - (signal[0] + signal[1]) / 2),
        np.sqrt(3 / 2) * (signal[3] - (signal[0] + signal[1] + signal[2]) / 3),
    ]
    white = Noise.white(np.sqrt(2) * sigma * RAD_PER_ARCSEC, rows)
    found = look(
        "radial_error_motion",
        measurement,
        {"capture": np.concatenate(contrasts)},
        {"capture": TrueNoise(white, np.zeros(rows, dtype=bool))},
        2 * index_sigma**2,
    )
    same_run = np.kron(np.eye(4), run[:, None] == run)
    covariance = sigma**2 * np.eye(4 * rows) + index_sigma**2 * same_run
    orders = np.arange(1, 21)
    angles = 2 * np.pi * (turn + np.array(places)[:, None] / 360)
    waves = np.exp(1j * orders * angles.ravel()[:, None])
    base = np.hstack([waves.real, waves.imag, np.tile(np.eye(rows), (4, 1))])
    whitened = np.linalg.cholesky(np.linalg.inv(covariance)).T
    target, columns = whitened @ signal.ravel(), whitened @ base
    left = target - columns @ np.linalg.lstsq(columns, target, rcond=1e-10)[0]
    assert found.noncentrality == pytest.approx(left @ left, rel=1e-6)


def test_search_for_the_faulty_head_costs() -> None:
    needed = [needed_noncentrality("timing_skew", heads, True) for heads in (2, 4)]
    assert needed[0] == needed_noncentrality("timing_skew")
    threshold = chi2.isf(FALSE_ALARM / 4, 1)
    draws = np.random.default_rng(2).normal(size=40_000) + np.sqrt(needed[1])
    # The tolerance is 6 standard deviations of a binomial rate of 0.95 in 40,000 draws, 0.0065.
    assert np.mean(draws**2 > threshold) == pytest.approx(POWER, abs=0.0065)


def test_a_constant_of_a_single_run_is_not_seen() -> None:
    """The oracle cannot see a constant in a single run, because an unknown offset of the index may
    have any size; several runs show how large the offset usually is."""
    rows = 240
    turn = np.linspace(0.0, 2.0, rows)
    counts = np.round(turn * COUNTS).astype(np.int64)
    seen = []
    for runs in (1, 4):
        run = np.repeat(np.arange(runs), rows // runs)
        capture = Capture(run, np.arange(rows) * 0.1, counts, counts)
        measurement = MeasurementSet(Table(COUNTS, 16384, 107.95, 33.0), capture, None, "")
        process = noise(rows)
        white = Noise(
            process.white_rad * RAD_PER_ARCSEC, process.sigma_rad * RAD_PER_ARCSEC, process.decay
        )
        constant = {"capture": np.full(rows, 50.0)}
        drawn = {"capture": TrueNoise(white, np.zeros(rows, dtype=bool))}
        seen.append(look("timing_skew", measurement, constant, drawn, 0.01).sees)
    assert seen == [False, True]


def test_what_is_needed_gives_the_power() -> None:
    recipe = REGISTRY["bearing_ball_pass"]
    rank, places = recipe.coefficients, recipe.places
    needed = needed_noncentrality("bearing_ball_pass")
    threshold = chi2.isf(FALSE_ALARM / places, rank)
    draws = np.random.default_rng(2).normal(size=(40_000, rank))
    draws[:, 0] += np.sqrt(needed)
    found = np.mean(np.sum(draws**2, axis=1) > threshold)
    # The tolerance is 6 standard deviations of a binomial rate of 0.95 in 40,000 draws, 0.0065.
    assert found == pytest.approx(POWER, abs=0.0065)


def test_every_cause_that_can_be_hidden_has_a_form() -> None:
    formed = {name for name, recipe in REGISTRY.items() if recipe.coefficients}
    assert formed == set(REGISTRY) - set(NOISES)


def test_statistic_of_drawn_noise_has_the_stated_noncentrality() -> None:
    """The projection of the rows on the cause's form is normal with mean √λ and standard deviation
    1, over sets that differ only in their noise."""
    experiment = full().smaller(100, 4)
    wanted, faint = Wanted("hysteresis", 0.25), Wanted("hysteresis", 0.25e-9)
    scores, expected = [], 0.0
    for again in range(DRAWS):
        made, without = (
            simulate_set(
                [item], experiment, 8, again=again, noise=[Wanted("ornstein_uhlenbeck", 0.1)]
            )
            for item in (wanted, faint)
        )
        form = {
            channel: exact - without.exact_arcsec[channel]
            for channel, exact in made.exact_arcsec.items()
        }
        arguments = (made.noise, made.index_variance_arcsec2)
        expected = look("hysteresis", made.measurement, form, *arguments).noncentrality
        reference = made.measurement.reference
        assert reference is not None
        # Hysteresis changes only the reference, so that the test uses the rows of the reference as
        # data.
        seen = {"capture": form["capture"], "reference": reference.error_arcsec}
        both = {name: form[name] + seen[name] for name in form}
        less = {name: form[name] - seen[name] for name in form}
        # (a+b)ᵀM(a+b) − (a−b)ᵀM(a−b) = 4·aᵀMb
        cross = (
            look("hysteresis", made.measurement, both, *arguments).noncentrality
            - look("hysteresis", made.measurement, less, *arguments).noncentrality
        ) / 4
        scores.append(cross / np.sqrt(expected))
    assert np.mean(scores) == pytest.approx(np.sqrt(expected), abs=4 / np.sqrt(DRAWS))
    assert np.std(scores) == pytest.approx(1.0, abs=4 / np.sqrt(2 * DRAWS))
