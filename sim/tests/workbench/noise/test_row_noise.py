"""Tests whitening and prediction of rows against calculations with the complete covariance."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from arctrue.workbench.noise.estimate import _scales
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.noise.spectrum import Spectrum, time_constants

SPECTRUM = Spectrum(0.5, np.array([0.1, 2.0]), np.array([0.7, 0.3]))
BREAK = 120
"""Row at which a new stretch begins; the noise of different stretches is independent."""


@pytest.fixture
def noise() -> RowNoise:
    random = np.random.default_rng(1)
    clock = np.concatenate(
        [np.sort(random.uniform(0.0, 10.0, BREAK)), np.sort(random.uniform(0.0, 5.0, 80))]
    )
    scale = random.uniform(0.5, 2.0, clock.size)
    return RowNoise(clock, np.array([0, BREAK]), (SPECTRUM, SPECTRUM), scale)


def _written_out(noise: RowNoise) -> np.ndarray:
    apart = np.abs(noise.clock[:, None] - noise.clock)
    covariance = 0.5 * np.eye(noise.rows)
    covariance += 0.7 * np.exp(-apart / 0.1) + 0.3 * np.exp(-apart / 2.0)
    stretch = np.arange(noise.rows) >= BREAK
    covariance[stretch[:, None] != stretch] = 0.0
    return covariance * np.outer(noise.scale, noise.scale)


def test_whitened_products_are_those_of_the_inverse_covariance(noise: RowNoise) -> None:
    values = np.random.default_rng(2).normal(size=(noise.rows, 3))
    covariance = _written_out(noise)
    whitened = noise.whiten(values)
    inverse = np.linalg.solve(covariance, values)
    np.testing.assert_allclose(whitened.T @ whitened, values.T @ inverse, rtol=1e-9)
    np.testing.assert_allclose(noise.precise(whitened), inverse, rtol=1e-8, atol=1e-12)
    assert noise.log_determinant == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-10)
    np.testing.assert_allclose(noise.coloured(whitened[:, 0]), values[:, 0], atol=1e-10)


def test_a_part_without_a_row_has_no_stretch(noise: RowNoise) -> None:
    none = noise.part(np.zeros(noise.rows, dtype=bool))
    assert none.stretches == []
    assert none.whiten(np.zeros((0, 3))).shape == (0, 3)
    assert none.log_determinant == 0.0


def test_left_out_rows_are_predicted_by_the_conditional_mean(noise: RowNoise) -> None:
    random = np.random.default_rng(3)
    values = random.normal(size=noise.rows)
    keep = random.random(noise.rows) < 0.7
    kept = noise.part(keep)
    covariance = _written_out(noise)
    expected = covariance[np.ix_(~keep, keep)] @ np.linalg.solve(
        covariance[np.ix_(keep, keep)], values[keep]
    )
    found = noise.expected(keep, kept.precise(kept.whiten(values[keep])))
    np.testing.assert_allclose(found, expected, atol=1e-10)


def test_spectral_density_is_the_transform_of_the_covariance() -> None:
    frequency, step = np.array([0.0, 0.3, 2.0, 9.0]), 0.05
    lags = np.arange(-4000, 4001) * step
    covariance = 0.7 * np.exp(-np.abs(lags) / 0.1) + 0.3 * np.exp(-np.abs(lags) / 2.0)
    covariance[4000] += 0.5
    expected = np.cos(2.0 * np.pi * np.outer(frequency, lags)) @ covariance
    np.testing.assert_allclose(SPECTRUM.density(frequency, step), expected, rtol=1e-6)


def test_time_constants_go_from_twice_the_step_to_the_whole_span() -> None:
    found = time_constants(0.002, 36.0)
    assert found[0] == pytest.approx(0.004)
    assert found[-1] == pytest.approx(36.0)
    assert np.all(found[1:] / found[:-1] <= 8.0)
    assert time_constants(1.0, 3.0).size == 0


def test_rows_without_any_scatter_have_no_uneven_noise() -> None:
    """A constant error (a sensor that stands) leaves residuals of zero: no group has more noise
    than another, and the logarithm of zero is not taken."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert _scales(np.zeros(300), np.repeat([0, 1, 2], 100), 3) is None
