"""Tests that coefficient_memory stores words, reads them back, and takes all words for one angle
from the same bank."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("lanes", "fold", "phase_offset_delay", "amplitude_delay", "offset_delay"),
    [
        pytest.param(5, 1, 4, 21, 25, marks=pytest.mark.large),
        (1, 1, 1, 1, 1),
        pytest.param(64, 1, 4, 21, 25, marks=pytest.mark.large),
        pytest.param(6, 2, 2, 21, 26, marks=pytest.mark.large),
        (2, 2, 2, 21, 26),
        (4, 4, 2, 21, 28),
        pytest.param(16, 8, 3, 22, 32, marks=pytest.mark.large),
    ],
)
def test_coefficient_memory(
    lanes: int, fold: int, phase_offset_delay: int, amplitude_delay: int, offset_delay: int
) -> None:
    generics = {
        "LANES": lanes,
        "FOLD": fold,
        "PHASE_OFFSET_DELAY": phase_offset_delay,
        "AMPLITUDE_DELAY": amplitude_delay,
        "OFFSET_DELAY": offset_delay,
    }
    simulate(
        "coefficient_memory",
        "tb.coefficients.coefficient_memory_bench",
        generics=generics,
        environment={name: str(value) for name, value in generics.items()},
    )
