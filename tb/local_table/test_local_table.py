"""Runs the benches of the local table in GHDL."""

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    "counts_per_rev", [2**24, pytest.param(1_234_567, marks=pytest.mark.large)]
)
def test_local_table(counts_per_rev: int) -> None:
    simulate(
        "local_table",
        "tb.local_table.local_table_bench",
        environment={"COUNTS_PER_REV": str(counts_per_rev)},
    )


@pytest.mark.parametrize(
    ("counts_per_rev", "testcase"),
    [
        (2**24, "a_table_acts_with_its_swap_and_is_kept"),
        pytest.param(2**24, "a_write_waits_for_a_swap", marks=pytest.mark.large),
        pytest.param(1_234_567, None, marks=pytest.mark.large),
    ],
)
def test_local_table_banks(counts_per_rev: int, testcase: str | None) -> None:
    simulate(
        "local_table_banks",
        "tb.local_table.local_table_banks_bench",
        testcase=testcase,
        environment={"COUNTS_PER_REV": str(counts_per_rev)},
    )
