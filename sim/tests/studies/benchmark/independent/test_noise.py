"""Tests of the independent generator's noise processes against complete covariance matrices."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize

from arctrue.studies.benchmark.independent.noise import (
    DrivenOscillator,
    FlickerNoise,
    NoiseProcess,
    RandomWalk,
    Relaxation,
    StateNoise,
)
from arctrue.studies.benchmark.independent.sight import Channel, look_at_oscillators

WHITE = 0.3
UNEVEN_S = np.cumsum(np.random.default_rng(1).uniform(0.2, 1.5, 60))
EXACT = 1e-8
"""Relative tolerance of a Kalman filter over 60 rows in double precision."""
DRAWS = 4_000
FOUR_SIGMA = 4 * np.sqrt(2 / DRAWS)
"""Tolerance of an empirical variance, relative to the expected variance."""


def lags(time_s: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.abs(time_s[:, None] - time_s[None, :])


def relaxation(time_s: NDArray[np.float64]) -> NDArray[np.float64]:
    return 0.5**2 * np.exp(-lags(time_s) / 7.0)


def walk(time_s: NDArray[np.float64]) -> NDArray[np.float64]:
    begun = time_s - time_s[0]
    return 0.2**2 * np.minimum(begun[:, None], begun[None, :])


def oscillator(time_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the covariance σ²·exp(−γt)·(cos ω₁t + γ/ω₁·sin ω₁t) of textbooks, with ω₁² = ω₀² −
    γ²."""
    natural = 2 * np.pi * 0.15
    damping = natural / (2 * 4.0)
    rate = np.sqrt(natural**2 - damping**2)
    lag = lags(time_s)
    shape = np.cos(rate * lag) + damping / rate * np.sin(rate * lag)
    return 0.4**2 * np.exp(-damping * lag) * shape


STATES = (Relaxation(0.5, 7.0), RandomWalk(0.2), DrivenOscillator(0.4, 0.15, 4.0))
COVARIANCES: tuple[Callable[[NDArray[np.float64]], NDArray[np.float64]], ...] = (
    relaxation,
    walk,
    oscillator,
)


@pytest.mark.parametrize("chosen", [(0,), (1,), (2,), (0, 1), (0, 1, 2)])
def test_whitening_is_the_inverse_cholesky_factor_of_the_covariance(chosen: tuple[int]) -> None:
    noise = StateNoise(WHITE, tuple(STATES[place] for place in chosen))
    covariance = WHITE**2 * np.eye(UNEVEN_S.size)
    covariance += sum(COVARIANCES[place](UNEVEN_S) for place in chosen)
    columns = np.random.default_rng(2).standard_normal((UNEVEN_S.size, 3))
    expected = np.linalg.solve(np.linalg.cholesky(covariance), columns)
    np.testing.assert_allclose(noise.whiten(columns, UNEVEN_S), expected, rtol=EXACT, atol=EXACT)


@pytest.mark.parametrize(
    "place", [0, pytest.param(1, marks=pytest.mark.large), pytest.param(2, marks=pytest.mark.large)]
)
def test_draws_have_the_stated_covariance(place: int) -> None:
    noise = StateNoise(WHITE, (STATES[place],))
    random = np.random.default_rng(3)
    time_s = UNEVEN_S[:12]
    drawn = np.array([noise.draw(random, time_s) for _ in range(DRAWS)])
    expected = WHITE**2 * np.eye(time_s.size) + COVARIANCES[place](time_s)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    found = drawn.T @ drawn / DRAWS
    assert np.max(np.abs(found - expected) / scale) < 1.5 * FOUR_SIGMA  # largest of 78 values


def test_flicker_noise_is_whitened_by_the_inverse_of_its_impulse_response() -> None:
    noise = FlickerNoise(0.2, 0.8)
    rows = np.arange(40)
    response = np.ones(40)
    for at in rows[1:]:
        response[at] = response[at - 1] * (at - 1 + 0.4) / at
    factor = 0.2 * np.array([[response[i - j] if i >= j else 0.0 for j in rows] for i in rows])
    columns = np.random.default_rng(4).standard_normal((40, 2))
    expected = np.linalg.solve(factor, columns)
    np.testing.assert_allclose(noise.whiten(columns, rows * 1.0), expected, rtol=0, atol=1e-9)


def test_flicker_noise_falls_as_one_over_f() -> None:
    """Flicker noise falls as 1/f: the slope of log power against log frequency is fitted to
    averaged periodograms over two decades."""
    noise, random = FlickerNoise(1.0, 1.0), np.random.default_rng(5)
    time_s = np.arange(4096.0)
    power = np.zeros(2049)
    for _ in range(40):
        power += np.abs(np.fft.rfft(noise.draw(random, time_s) * np.hanning(4096))) ** 2
    at = np.arange(8, 400)
    slope = np.polyfit(np.log(at), np.log(power[at]), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.08)  # chance: 0.02, plus the window's leakage


def test_heavy_tails_keep_their_standard_deviation_and_tell_more_than_it_says() -> None:
    """The noise has the stated Fisher information about a shift; the test integrates the
    information numerically over the density of Student's t."""
    from scipy.stats import t

    noise = StateNoise(0.3, (), 4.0)
    drawn = noise.draw(np.random.default_rng(6), np.arange(400_000.0))
    # With four degrees of freedom the fourth moment is infinite; therefore the tolerance was found
    # by trial.
    assert drawn.std() == pytest.approx(0.3, rel=0.03)
    scale = 0.3 * np.sqrt(0.5)
    x = np.linspace(-60, 60, 400_001) * scale
    density = t.pdf(x, 4.0, scale=scale)
    information = np.sum(np.gradient(density, x) ** 2 / density) * (x[1] - x[0])
    whitened = noise.whiten(np.ones((1, 1)), np.zeros(1))[0, 0]
    assert whitened**2 == pytest.approx(information, rel=1e-3)


@pytest.mark.parametrize(
    "noise",
    [StateNoise(0.1, STATES[:1]), StateNoise(0.1, STATES[1:2]), FlickerNoise(0.1, 0.7)],
)
def test_scaling_and_stated_size(noise: NoiseProcess) -> None:
    time_s = np.arange(300.0)
    random = np.random.default_rng(7)
    drawn = np.array([noise.draw(random, time_s) for _ in range(400)])
    about = drawn - drawn.mean(axis=1, keepdims=True)
    # The mean over 300 s contains only a small part of a relaxation of 7 s and of 1/f noise.
    assert np.sqrt(np.mean(about**2)) == pytest.approx(noise.rms_arcsec(time_s), rel=0.1)
    one = noise.whiten(drawn[:1].T, time_s)
    np.testing.assert_allclose(noise.scaled(3.0).whiten(3 * drawn[:1].T, time_s), one)
    assert np.all(
        np.abs(noise.with_white(0.5).whiten(drawn[:1].T, time_s)).sum() < np.abs(one).sum()
    )


def test_the_mean_periodogram_is_that_of_the_covariance_matrix() -> None:
    """The mean periodogram is vᴴ·C·v/N, for the Fourier vectors v of the rows and the complete
    covariance matrix C."""
    time_s = 0.7 * np.arange(91)
    noise = StateNoise(WHITE, (STATES[0], STATES[2]))
    covariance = relaxation(time_s) + oscillator(time_s) + WHITE**2 * np.eye(time_s.size)
    waves = np.exp(-2j * np.pi * np.outer(np.arange(1, 46), np.arange(91)) / 91)
    expected = np.einsum("ki,ij,kj->k", waves.conj(), covariance, waves).real / 91
    assert noise.mean_periodogram(91, 0.7) == pytest.approx(expected, rel=EXACT)
    with pytest.raises(ValueError, match="random walk"):
        StateNoise(WHITE, (RandomWalk(0.2),)).mean_periodogram(91, 0.7)


def kullback_leibler(true: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return twice the mean log likelihood ratio of two normal densities with mean 0 and the
    covariances ``true`` and ``other``."""
    left = np.linalg.solve(other, true)
    return float(np.trace(left) - len(true) - np.linalg.slogdet(left)[1])


@pytest.mark.large
@pytest.mark.parametrize("quality", [3.0, 12.0])
def test_the_oracle_sees_of_an_oscillator_what_no_falling_spectrum_explains(quality: float) -> None:
    """The oracle's noncentrality lies between bounds from an exact likelihood ratio, computed with
    dense matrices.

    The ratio compares the oscillator with the nearest sum of white noise and a relaxation. Of all
    falling spectra the isotonic one, which the oracle uses, is nearest to the oscillator, so the
    noncentrality cannot exceed the ratio; the upper bound allows 10 % for the ends of the record,
    which the spectrum ignores. The lower bound is a third of the ratio, because a falling spectrum
    with a step is nearer than a relaxation; for a quality of 3 the factor is 2.5.
    """
    time_s = 0.7 * np.arange(300)
    shaken = DrivenOscillator(0.4, 0.25, quality)
    noise = StateNoise(WHITE, (shaken,))
    natural = 2 * np.pi * shaken.hz
    damping = natural / (2 * quality)
    rate = np.sqrt(natural**2 - damping**2)
    lag = lags(time_s)
    shape = np.cos(rate * lag) + damping / rate * np.sin(rate * lag)
    true = 0.4**2 * np.exp(-damping * lag) * shape + WHITE**2 * np.eye(time_s.size)

    def far(logs: NDArray[np.float64]) -> float:
        white, slow, tau = np.exp(logs)
        other = white * np.eye(time_s.size) + slow * np.exp(-lag / tau)
        return kullback_leibler(true, other)

    nearest = minimize(far, np.log([0.2, 0.05, 2.0]), method="Nelder-Mead").fun
    rows = np.arange(time_s.size)
    seen = look_at_oscillators(Channel("reference", time_s, time_s, noise, None, rows))
    assert seen is not None
    assert nearest / 3.0 < seen.noncentrality < 1.1 * nearest
    assert seen.rms_arcsec == pytest.approx(0.4)
    plain = Channel("reference", time_s, time_s, StateNoise(WHITE), None, rows)
    assert look_at_oscillators(plain) is None
