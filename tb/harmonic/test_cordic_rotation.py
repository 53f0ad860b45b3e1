"""Tests that the CORDIC rotation in VHDL equals its model bit by bit, with the default and other
generics."""

import pytest

from tb.harmonic.harmonic_generics import DEFAULT, OTHERS, environment, generics
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("width", "iterations", "angles"),
    [
        (*DEFAULT, 3000),
        pytest.param(*DEFAULT, 20_000, marks=pytest.mark.large),
        *((*other, 3000) for other in OTHERS[2:4]),
        *(
            pytest.param(*other, 3000, marks=pytest.mark.large)
            for other in (*OTHERS[:2], *OTHERS[4:])
        ),
    ],
)
def test_cordic_rotation(width: int, iterations: int, angles: int) -> None:
    values = generics(width, iterations)
    simulate(
        "cordic_rotation",
        "tb.harmonic.cordic_rotation_bench",
        generics=values,
        environment=environment(**values, ANGLES=angles),
    )
