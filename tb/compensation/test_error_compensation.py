"""Tests that adder tree, ramp and subtraction in VHDL equal their models, bit by bit."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    "lanes",
    [
        pytest.param(1, marks=pytest.mark.large),
        pytest.param(4, marks=pytest.mark.large),
        9,
        32,
        pytest.param(64, marks=pytest.mark.large),
    ],
)
def test_error_compensation(lanes: int) -> None:
    """The cases cover every number of groups in the adder tree, and an odd number of lanes."""
    simulate(
        "error_compensation",
        "tb.compensation.error_compensation_bench",
        generics={"LANES": lanes},
        environment={"LANES": str(lanes)},
    )


@pytest.mark.parametrize(
    ("lanes", "fold"),
    [
        pytest.param(1, 8, marks=pytest.mark.large),
        (16, 2),
        pytest.param(8, 4, marks=pytest.mark.large),
        pytest.param(32, 2, marks=pytest.mark.large),
    ],
)
def test_folded_sums(lanes: int, fold: int) -> None:
    simulate(
        "error_compensation",
        "tb.compensation.error_compensation_bench",
        generics={"LANES": lanes, "FOLD": fold},
        testcase=f"folded_sums/fold={fold}",
        environment={"LANES": str(lanes), "FOLD": str(fold)},
    )


@pytest.mark.parametrize(
    "lanes",
    [
        pytest.param(1, marks=pytest.mark.large),
        9,
        pytest.param(32, marks=pytest.mark.large),
        pytest.param(64, marks=pytest.mark.large),
    ],
)
def test_mean_of_the_heads(lanes: int) -> None:
    """The adder tree adds the mean's term as one more addend; the cases cover every number of
    groups."""
    simulate(
        "error_compensation",
        "tb.compensation.error_compensation_bench",
        generics={"LANES": lanes, "MEAN": "true"},
        testcase="mean_joins_before_the_rounding",
        environment={"LANES": str(lanes), "MEAN": "true"},
    )
