"""Tests that noise in the time domain agrees with closed forms, and that a consumer refuses noise
that it cannot apply."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import periodogram

from arctrue.instrument.curves import TableCurves
from arctrue.table import Motion, RotaryTable, count_edges, two_heads
from arctrue.table.cause import Cause, UnhonouredCauseError, acts_on
from arctrue.table.causes.autoregressive_noise import AutoregressiveNoise
from arctrue.table.causes.lost_counts import LostCounts
from arctrue.table.causes.noise_by_angle import NoiseByAngle
from arctrue.table.causes.outliers import Outliers
from arctrue.table.causes.polygon_faces import PolygonFaces
from arctrue.table.causes.power_law_noise import PowerLawNoise
from arctrue.table.causes.relaxing_noise import RelaxingNoise
from arctrue.table.causes.swinging_speed import SwingingSpeed
from arctrue.table.causes.time_gaps import TimeGaps
from arctrue.table.causes.white_noise import WhiteNoise
from arctrue.table.conditions import Conditions, travelled_turns
from arctrue.table.noise import Noise, together
from arctrue.table.registry import NOISES, REGISTRY
from arctrue.table.state import TableState
from arctrue.table.temperature import TemperatureCourse

DRAWS = 4000
SCATTER = 6 * np.sqrt(2 / DRAWS)
"""Six standard errors of a variance of 1 that is estimated from DRAWS draws."""


def rows(number: int, period_s: float = 0.01) -> Conditions:
    time_s = np.arange(number) * period_s
    run = (np.arange(number) >= number // 2).astype(np.int64)
    zero = np.zeros(number)
    return Conditions(time_s, 0.5 * time_s, zero + 0.5, zero + 20.0, zero + 1.0, run, time_s, zero)


def drawn_covariance(noise: Noise) -> np.ndarray:
    random = np.random.default_rng(1)
    draws = np.stack([noise.draw(random) for _ in range(DRAWS)])
    return draws.T @ draws / DRAWS


@pytest.mark.parametrize(
    "cause",
    [
        WhiteNoise(1.0),
        NoiseByAngle((0.0, -0.5), 0.7, 2, 0.9, 0.3),
        RelaxingNoise(1.0, 0.05),
        AutoregressiveNoise(1.0, 0.8),
        PowerLawNoise(1.0, 1.5, 0.02, 2.0),
    ],
    ids=lambda cause: type(cause).__name__,
)
def test_draws_have_the_covariance_that_is_stated(cause: object) -> None:
    noise = cause.head_noise(0, rows(12))  # type: ignore[attr-defined]
    np.testing.assert_allclose(drawn_covariance(noise), noise.covariance(), atol=2 * SCATTER)


def test_relaxing_covariance_is_exponential_in_time_also_over_a_gap() -> None:
    time_s = np.array([0.0, 0.1, 0.15, 3.0, 3.1])
    noise = Noise.relaxing(np.array([2.0]), np.array([0.5]), time_s)
    expected = 4.0 * np.exp(-np.abs(time_s[:, None] - time_s) / 0.5)
    np.testing.assert_allclose(noise.covariance(), expected, rtol=1e-12)
    kept = np.array([True, False, True, False, True])
    np.testing.assert_allclose(noise.rows(kept).covariance(), expected[np.ix_(kept, kept)])


def test_autoregressive_noise_is_its_recursion_and_begins_anew_with_a_run() -> None:
    covariance = AutoregressiveNoise(1.0, -0.6).head_noise(0, rows(8)).covariance()
    np.testing.assert_allclose(covariance[0, :4], (-0.6) ** np.arange(4), atol=1e-12)
    np.testing.assert_array_equal(covariance[:4, 4:], 0.0)


def test_left_out_rows_keep_the_sign_of_the_correlation() -> None:
    noise = AutoregressiveNoise(1.0, -0.6).head_noise(0, rows(8))
    kept = np.array([1, 0, 1, 1, 0, 1, 0, 1], dtype=bool)
    expected = noise.covariance()[np.ix_(kept, kept)]
    np.testing.assert_allclose(noise.rows(kept).covariance(), expected, atol=1e-12)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5])
def test_power_law_has_its_slope_between_its_corner_frequencies(exponent: float) -> None:
    # The frequencies lie between the corners 1/(2π·300 s) and 1/(2π·0.1 ms), and below the Nyquist
    # frequency. Over 40 draws of 80 lines the slope scatters by 0.01; the tolerance of 0.05 leaves
    # room for the ripple of the sum.
    noise = PowerLawNoise(1.0, exponent).head_noise(0, rows(8192, 1e-3))
    random = np.random.default_rng(3)
    spectra = [periodogram(noise.draw(random), 1000.0, "hann")[1] for _ in range(40)]
    frequency_hz = np.fft.rfftfreq(8192, 1e-3)
    inside = (frequency_hz > 0.5) & (frequency_hz < 10.0)
    slope = np.polyfit(np.log(frequency_hz[inside]), np.log(np.mean(spectra, 0)[inside]), 1)[0]
    assert slope == pytest.approx(-exponent, abs=0.05)
    assert np.sum(noise.sigma_rad**2) == pytest.approx(1.0)


def test_noise_does_not_come_round_at_the_end_of_a_run() -> None:
    # A draw from a Fourier series would be periodic: its end and its beginning would have a
    # correlation of 0.99.
    noise = RelaxingNoise(1.0, 1.0).head_noise(0, rows(3000))
    random = np.random.default_rng(2)
    ends = np.array([noise.draw(random)[[0, -1]] for _ in range(400)])
    assert abs(np.corrcoef(ends.T)[0, 1]) < 4 / np.sqrt(400)


def test_sum_of_noises_has_the_sum_of_their_covariances() -> None:
    parts = [WhiteNoise(0.5).head_noise(0, rows(6)), RelaxingNoise(1.0, 0.1).head_noise(0, rows(6))]
    whole = together([part for part in parts if part is not None], 6)
    expected = sum(part.covariance() for part in parts if part is not None)
    np.testing.assert_allclose(whole.covariance(), expected)


def test_a_spectrum_without_a_variance_is_refused() -> None:
    with pytest.raises(ValueError, match="0 … 2"):
        PowerLawNoise(1.0, 2.5)


def test_outliers_strike_as_many_rows_as_they_say() -> None:
    struck = Outliers(0.02, 1.0).struck_rad(0, rows(20_000), np.random.default_rng(1))
    # Six standard deviations of the binomial distribution of the outliers' number are 119.
    assert abs(np.count_nonzero(struck) - 400) < 120


def test_gaps_leave_out_their_share_and_no_end_of_a_run() -> None:
    state = rows(40_000)
    kept = TimeGaps(0.1, 20.0).kept_rows(state, np.random.default_rng(1))
    # About 200 stretches overlap, so that they cover 1 − exp(−0.1) of the rows.
    assert np.mean(~kept) == pytest.approx(1 - np.exp(-0.1), abs=6 * 0.1 / np.sqrt(200) * 2)
    assert kept[[0, 19_999, 20_000, -1]].all()


def test_lagging_sensor_solves_its_differential_equation() -> None:
    course = TemperatureCourse((10.0, 100.0, 400.0, 500.0), (20.0, 26.0, 23.0, 23.0))
    time_s = np.linspace(0.0, 900.0, 91)
    solved = solve_ivp(
        lambda t, y: (course.at(np.array([t])) - y) / 120.0,
        (0.0, 900.0),
        [20.0],
        t_eval=time_s,
        rtol=1e-9,
        atol=1e-9,
        max_step=5.0,
    )
    np.testing.assert_allclose(course.lagging(time_s, 120.0), solved.y[0], atol=1e-5)


@pytest.mark.parametrize(
    ("times", "temperatures"), [((), ()), ((0.0, 1.0), (20.0,)), ((1.0, 1.0), (20.0, 21.0))]
)
def test_what_is_no_temperature_course_is_refused(
    times: tuple[float, ...], temperatures: tuple[float, ...]
) -> None:
    with pytest.raises(ValueError, match="temperature course"):
        TemperatureCourse(times, temperatures)


def test_swinging_speed_swings_by_its_share() -> None:
    motion = SwingingSpeed(0.05, 4, 0.3).driven(Motion.steady(2.0, 10.0))
    speed = motion.state(np.linspace(0.0, 10.0, 5001)).speed_rad_s
    assert (speed.min(), speed.max()) == pytest.approx((1.9, 2.1), rel=1e-5)


@pytest.mark.parametrize("cause", [PolygonFaces((0.0,)), SwingingSpeed(0.1, 1, 0.0), WhiteNoise(1)])
def test_a_cause_that_edges_do_not_have_is_an_error(cause: Cause) -> None:
    table = RotaryTable(two_heads(), (cause,), counts_per_rev=4096)
    motion = Motion.steady(1.0, 1.0)
    with pytest.raises(UnhonouredCauseError, match=type(cause).__name__):
        count_edges(table, 0, motion)
    with pytest.raises(UnhonouredCauseError, match=next(iter(acts_on(cause)))):
        table.counts(0, motion.state(np.zeros(1)))
    with pytest.raises(UnhonouredCauseError, match="virtual instrument"):
        TableCurves(table, motion, 1e6)


def test_lost_counts_are_lost_by_one_counter() -> None:
    state = Motion.steady(1.0, 2.0).state(np.linspace(0.0, 2.0, 201))
    tables = [
        RotaryTable(two_heads(), causes, counts_per_rev=4096)
        for causes in ((), (LostCounts(0, 0, -1.0, 7),))
    ]
    for head, lost in ((0, 7), (1, 0)):
        counts = [table.counts(head, state) for table in tables]
        np.testing.assert_array_equal(counts[1] - counts[0], [lost] * 201)


def test_wear_needs_to_know_how_far_the_table_has_turned() -> None:
    with pytest.raises(ValueError, match="the travel of the table"):
        travelled_turns(TableState.at_rest(np.zeros(1)))


def test_noises_stand_in_the_registry_with_the_physical_causes() -> None:
    assert set(NOISES) < set(REGISTRY)
    assert {"white", "pink", "power_law", "ornstein_uhlenbeck", "autoregressive"} <= set(NOISES)
