"""Tests that prepared_sets stores sets of words, loads each set completely, and swaps it."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(("heads", "lanes"), [pytest.param(3, 3, marks=pytest.mark.large), (4, 4)])
def test_prepared_sets(heads: int, lanes: int) -> None:
    simulate(
        "prepared_sets",
        "tb.mean.prepared_sets_bench",
        generics={"HEADS": heads, "LANES": lanes},
        environment={"HEADS": str(heads), "LANES": str(lanes)},
    )
