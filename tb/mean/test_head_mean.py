"""Tests that head_mean and mean_words swap all words together without a jump of the position."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    "heads", [*(pytest.param(heads, marks=pytest.mark.large) for heads in (2, 3)), 4]
)
@pytest.mark.parametrize("entity", ["mean_words", "head_mean"])
def test_mean(entity: str, heads: int) -> None:
    simulate(
        entity,
        f"tb.mean.{entity}_bench",
        generics={"HEADS": heads},
        environment={"HEADS": str(heads)},
    )
