"""Tests that the delay line delays words by exactly CLOCKS clocks."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("width", "clocks"), [pytest.param(58, 25, marks=pytest.mark.large), (1, 1), (24, 2)]
)
def test_delay_line(width: int, clocks: int) -> None:
    simulate(
        "delay_line",
        "tb.compensation.delay_line_bench",
        generics={"WIDTH": width, "CLOCKS": clocks},
        environment={"WIDTH": str(width), "CLOCKS": str(clocks)},
    )
