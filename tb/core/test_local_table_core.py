"""Runs in GHDL the bench of the whole core with a local table.

``sim/tests/studies/hidden_effect/test_scratch.py`` runs the netlist of a core that has a pipeline
for each lane.
"""

from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("fold", "testcase"),
    [
        (4, ("scratches_are_taken_away/signs=1", "words_of_the_table")),
        pytest.param(1, None, marks=pytest.mark.large),
        pytest.param(4, None, marks=pytest.mark.large),
    ],
)
def test_core_with_a_local_table(fold: int, testcase: tuple[str, ...] | None) -> None:
    """The core holds the words of a local table and corrects scratches with it. ``tb/local_table``
    compares the table and its banks with their models."""
    simulate(
        "arctrue_core",
        "tb.core.local_table_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "FOLD": fold,
            "LOCAL_TABLE": "true",
        },
        testcase=testcase,
        environment={"FOLD": str(fold)},
    )
