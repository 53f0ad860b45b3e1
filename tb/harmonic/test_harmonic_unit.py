"""Tests that harmonic_unit in VHDL, which adds the terms of the lanes in pairs, equals its model,
also for odd numbers of lanes."""

import pytest

from tb.harmonic.harmonic_generics import DEFAULT, environment, generics
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("lanes", "angles", "width", "iterations"),
    [
        (1, 500, *DEFAULT),
        (2, 500, *DEFAULT),
        pytest.param(5, 500, *DEFAULT, marks=pytest.mark.large),
        pytest.param(32, 600, *DEFAULT, marks=pytest.mark.large),
        pytest.param(64, 100, *DEFAULT, marks=pytest.mark.large),
        (3, 500, 14, 12),
        pytest.param(4, 500, 20, 18, marks=pytest.mark.large),
    ],
)
def test_harmonic_unit(lanes: int, angles: int, width: int, iterations: int) -> None:
    values = {"LANES": lanes, **generics(width, iterations)}
    simulate(
        "harmonic_unit",
        "tb.harmonic.harmonic_unit_bench",
        generics=values,
        environment=environment(**values, ANGLES=angles),
    )


@pytest.mark.parametrize(
    "lanes",
    [
        1,
        pytest.param(2, marks=pytest.mark.large),
        pytest.param(5, marks=pytest.mark.large),
        pytest.param(32, marks=pytest.mark.large),
    ],
)
def test_from_the_table(lanes: int) -> None:
    values: dict[str, int | str] = {"LANES": lanes, "ROTATION": "table"}
    simulate(
        "harmonic_unit",
        "tb.harmonic.harmonic_unit_bench",
        generics=values,
        environment=environment(**values, ANGLES=400),
    )
