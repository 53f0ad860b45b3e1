"""A folded lane reads its coefficients in turn."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("lanes", "fold", "width", "clocks"),
    [(3, 1, 24, 2), (6, 2, 25, 21), (4, 4, 48, 0), (16, 8, 7, 3)],
)
def test_coefficient_selector(lanes: int, fold: int, width: int, clocks: int) -> None:
    generics = {"LANES": lanes, "FOLD": fold, "WIDTH": width, "CLOCKS": clocks}
    simulate(
        "coefficient_selector",
        "tb.coefficients.coefficient_selector_bench",
        generics=generics,
        environment={name: str(value) for name, value in generics.items()},
    )
