"""Tests of columns and sums of harmonics against the cosine and sine of each multiple."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.workbench.numeric.harmonics import harmonic_columns, harmonic_sum

ANGLE = np.random.default_rng(5).uniform(-2000.0, 2000.0, 20_000)
"""Angles in rad over several hundred turns, enough to fill more than two blocks of a sum."""
TOLERANCE = 1e-11
"""Largest error of twenty multiplications of rounded factors; the last bit of the angle is 2e-13
rad."""


@pytest.mark.parametrize(
    "orders",
    [(1, 2, 3, 4), (1, 2, 4, 5, 7, 20), tuple(n for n in range(1, 21) if n != 11), (), (0.5, 3.0)],
)
def test_columns_are_cosine_and_sine_of_every_order(orders: tuple[float, ...]) -> None:
    columns = harmonic_columns(ANGLE, orders)
    assert columns.shape == (ANGLE.size, 2 * len(orders))
    for index, order in enumerate(orders):
        expected = np.cos(order * ANGLE), np.sin(order * ANGLE)
        np.testing.assert_allclose(columns[:, 2 * index], expected[0], atol=TOLERANCE)
        np.testing.assert_allclose(columns[:, 2 * index + 1], expected[1], atol=TOLERANCE)


@pytest.mark.parametrize("orders", [(1,), (3, 1, 20), tuple(range(1, 11))])
def test_sum_is_columns_times_coefficients(orders: tuple[int, ...]) -> None:
    coefficients = np.random.default_rng(6).normal(size=2 * len(orders))
    waves = [
        a * np.cos(n * ANGLE) + b * np.sin(n * ANGLE)
        for n, a, b in zip(orders, coefficients[::2], coefficients[1::2], strict=True)
    ]
    found = harmonic_sum(ANGLE, orders, coefficients)
    np.testing.assert_allclose(found, np.sum(waves, axis=0), atol=TOLERANCE)
