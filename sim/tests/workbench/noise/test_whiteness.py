"""Tests of whitened residuals: right level on white noise, and they see what is not white."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import jarque_bera  # type: ignore[import-untyped]

from arctrue.workbench.noise.whiteness import whiteness


def test_white_noise_fails_as_often_as_the_level_says() -> None:
    random = np.random.default_rng(3)
    tests = [whiteness(random.normal(size=800)) for _ in range(300)]
    for name in ("autocorrelation_p", "normality_p"):
        rare = sum(getattr(item, name) < 0.1 for item in tests)
        # 30 expected, standard deviation 5.2: four of them.
        assert 9 < rare < 51, name


def test_correlated_and_heavy_tailed_rows_are_seen() -> None:
    random = np.random.default_rng(4)
    white = random.normal(size=2001)
    correlated = whiteness(white[1:] + 0.3 * white[:-1])
    assert correlated is not None
    assert correlated.autocorrelation_p < 1e-6
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


def test_too_few_rows_and_no_residual_have_no_test() -> None:
    assert whiteness(np.ones(5)) is None
    assert whiteness(np.zeros(100)) is None
