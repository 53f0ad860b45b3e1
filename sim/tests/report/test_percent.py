"""Tests that a probability is never shown as certain."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.base.percent import probability_percent


@pytest.mark.parametrize("value", [0.0, 1e-9, 0.005, 0.00500001, 0.5, 0.99499999, 0.995, 1.0])
def test_no_probability_is_0_or_100_percent(value: float) -> None:
    assert probability_percent(value) not in ("0 %", "100 %")


def test_the_shown_percent_is_the_nearest() -> None:
    for value in np.arange(0.01, 0.99, 0.0137):
        assert abs(float(probability_percent(value).split()[0]) - 100.0 * value) <= 0.5
