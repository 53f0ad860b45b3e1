"""Tests how values are printed with their standard uncertainty, and how probabilities are
printed."""

from math import inf, nan

import pytest

from arctrue.base.figures import probability, with_uncertainty


@pytest.mark.parametrize(
    ("value", "sigma", "unit", "text"),
    [
        (0.954082, 0.0013, "arcsec/K", "0.9541″/K ± 0.0013″/K"),
        (-1197.78, 20.4, "arcsec", "−1198″ ± 20″"),
        (12345.6, 321.0, "deg", "12346° ± 321°"),
        (33.0811, 0.0996, "deg", "33.081° ± 0.100°"),
        (0.5, 2.0, "1", "0.5 ± 2.0"),
        (126.0, nan, "1", "126"),
        (14.6192, 0.0, "s", "14.6192 s"),
        (nan, 1.0, "s", "nan s"),
        (1.0, inf, "s", "1 s"),
        (2.5, 0.11, "um/K", "2.50 ± 0.11 µm/K"),
    ],
)
def test_two_digits_of_the_uncertainty(value: float, sigma: float, unit: str, text: str) -> None:
    assert with_uncertainty(value, sigma, unit) == text


def test_probabilities_have_two_digits_and_a_lower_limit() -> None:
    assert [probability(p) for p in (0.0, 9e-10, 2e-9, 0.0312, 1.0)] == [
        "< 1e-9",
        "< 1e-9",
        "2e-09",
        "0.031",
        "1",
    ]
