"""Tests of whitened residuals: white noise fails the tests at the stated level, and the tests
detect other noise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import jarque_bera  # type: ignore[import-untyped]

from arctrue.workbench.noise.whiteness import autocorrelations, whiteness


def test_white_noise_fails_as_often_as_the_level_says() -> None:
    random = np.random.default_rng(3)
    tests = [whiteness(random.normal(size=800)) for _ in range(300)]
    for name in ("autocorrelation_p", "successive_differences_p", "normality_p"):
        rare = sum(getattr(item, name) < 0.1 for item in tests)
        # 30 failures are expected with a standard deviation of 5.2; the bounds are four standard
        # deviations away.
        assert 9 < rare < 51, name


@pytest.mark.parametrize(
    ("rows", "turns"),
    [
        (60, 1),
        pytest.param(120, 1, marks=pytest.mark.large),
        pytest.param(400, 1, marks=pytest.mark.large),
        pytest.param(1600, 1, marks=pytest.mark.large),
        (300, 2),
    ],
)
def test_what_a_model_takes_is_no_colour(rows: int, turns: int) -> None:
    """Residuals of white noise pass the tests although the model has absorbed noise. In an evenly
    spaced log, orders 1 to 20 absorb the noise at their frequencies; in the shortest log they
    absorb all noise below 20/60 cycles per row."""
    random = np.random.default_rng(8)
    angle = 2.0 * np.pi * turns * np.arange(rows) / rows
    phase = np.outer(angle, np.arange(1, 21))
    model = np.hstack([np.cos(phase), np.sin(phase)])
    own = np.linalg.qr(np.hstack([np.ones((rows, 1)), model]))[0]
    draws = random.normal(size=(300, rows))
    tests = [whiteness(values, model) for values in draws - draws @ own @ own.T]
    for name in ("autocorrelation_p", "successive_differences_p"):
        p_values = np.array([getattr(item, name) for item in tests])
        # 30 failures are expected with a standard deviation of 5.2; the bounds are four standard
        # deviations away.
        assert 9 < np.count_nonzero(p_values < 0.1) < 51, name
        # At a third of the level 0.01, one failure is expected; the probability of 8 or more
        # is below 1e-4 (Poisson).
        assert np.count_nonzero(p_values < 0.01 / 3.0) < 8, name


@pytest.mark.parametrize("rows", [150, pytest.param(300, marks=pytest.mark.large)])
def test_wild_rows_are_no_colour(rows: int) -> None:
    """Rows with large errors do not fail the tests of correlation: the fit distributes the error of
    such a row over its neighbours, and the tests must not take this for correlated noise."""
    random = np.random.default_rng(10)
    phase = np.outer(2.0 * np.pi * np.arange(rows) / rows, np.arange(1, 21))
    model = np.hstack([np.cos(phase), np.sin(phase)])
    own = np.linalg.qr(np.hstack([np.ones((rows, 1)), model]))[0]
    rare = 0
    for _ in range(300):
        values = random.normal(size=rows)
        values[random.choice(rows, 2, replace=False)] += random.choice([-1.0, 1.0], 2) * 30.0
        found = whiteness(values - own @ (own.T @ values), model)
        assert found is not None
        assert found.normality_p < 1e-6
        rare += found.autocorrelation_p < 0.1
    # 30 failures are expected with a standard deviation of 5.2; the bound is four standard
    # deviations away.
    assert 9 < rare < 51


def test_colour_above_the_orders_of_a_model_is_seen() -> None:
    random = np.random.default_rng(9)
    phase = np.outer(2.0 * np.pi * np.arange(400) / 400.0, np.arange(1, 21))
    model = np.hstack([np.cos(phase), np.sin(phase)])
    white = random.normal(size=401)
    values = white[1:] + 0.6 * white[:-1]
    own = np.linalg.qr(np.hstack([np.ones((400, 1)), model]))[0]
    found = whiteness(values - own @ (own.T @ values), model)
    assert found is not None
    assert found.autocorrelation_p < 1e-4


def test_correlated_and_heavy_tailed_rows_are_seen() -> None:
    random = np.random.default_rng(4)
    white = random.normal(size=2001)
    correlated = whiteness(white[1:] + 0.3 * white[:-1])
    assert correlated is not None
    assert correlated.autocorrelation_p < 1e-6
    assert correlated.successive_differences_p < 1e-6
    assert correlated.normality_p > 1e-3
    heavy = whiteness(random.standard_t(3, size=2000))
    assert heavy is not None
    assert heavy.normality_p < 1e-6
    assert heavy.autocorrelation_p > 1e-3


def test_normality_is_the_test_of_jarque_and_bera() -> None:
    values = np.random.default_rng(5).standard_t(9, size=700)
    found = whiteness(values)
    assert found is not None
    assert found.normality_p == pytest.approx(float(jarque_bera(values).pvalue), rel=1e-9)


def test_the_ratio_of_von_neumann_has_its_mean_and_variance() -> None:
    """The test uses the right mean and variance of von Neumann's ratio: a ratio that differs from
    the simulated mean by one simulated standard deviation must have p = 0.317."""
    random = np.random.default_rng(6)
    draws = random.normal(size=(4000, 24))
    draws -= draws.mean(axis=1, keepdims=True)
    ratio = np.sum(np.diff(draws) ** 2, axis=1) / np.sum(draws**2, axis=1)
    middle = draws[np.argmin(np.abs(ratio - ratio.mean()))]
    fixed_terms = draws[np.argmin(np.abs(ratio - ratio.mean() - ratio.std()))]
    for values, expected in ((middle, 1.0), (fixed_terms, 0.317)):
        found = whiteness(values)
        assert found is not None
        # 4,000 draws determine the mean to 1.6 % of the standard deviation, and the standard
        # deviation to 1.1 %.
        assert found.successive_differences_p == pytest.approx(expected, abs=0.06)


def test_autocorrelations_are_those_of_numpy() -> None:
    values = np.random.default_rng(7).normal(size=300)
    whole = np.correlate(values - values.mean(), values - values.mean(), "full")[299:]
    assert autocorrelations(values, 5) == pytest.approx(whole[1:6] / whole[0])


def test_too_few_rows_and_no_residual_have_no_test() -> None:
    assert whiteness(np.ones(5)) is None
    assert whiteness(np.zeros(100)) is None


def test_a_residual_whose_square_underflows_passes_like_one_of_zero() -> None:
    # 1e-90 squared is 1e-180, whose square is 0 in float64.
    small = 1e-90 * np.random.default_rng(4).normal(size=400)
    found = whiteness(small)
    assert found is not None
    assert found.normality_p == 1.0
