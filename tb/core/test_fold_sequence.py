"""Runs the bench of fold_sequence, which numbers the clocks of a pipeline in which FOLD lanes share
one circuit."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("fold", "sums_clock"),
    [
        pytest.param(1, 25, marks=pytest.mark.large),
        pytest.param(2, 25, marks=pytest.mark.large),
        (4, 25),
        pytest.param(8, 25, marks=pytest.mark.large),
        (8, 16),
    ],
)
def test_fold_sequence(fold: int, sums_clock: int) -> None:
    generics = {"FOLD": fold, "SUMS_CLOCK": sums_clock}
    simulate(
        "fold_sequence",
        "tb.core.fold_sequence_bench",
        generics=generics,
        environment={name: str(value) for name, value in generics.items()},
    )
