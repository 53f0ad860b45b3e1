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
    "counts_per_rev", [2**24, pytest.param(1_234_567, marks=pytest.mark.large)]
)
def test_local_table_banks(counts_per_rev: int) -> None:
    simulate(
        "local_table_banks",
        "tb.local_table.local_table_banks_bench",
        environment={"COUNTS_PER_REV": str(counts_per_rev)},
    )
