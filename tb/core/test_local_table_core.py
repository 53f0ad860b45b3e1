"""Runs in GHDL the bench of the whole core with a local table.

``sim/tests/studies/hidden_effect/test_scratch.py`` runs the netlist of a core that has a pipeline
for each lane.
"""

from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("fold", "signs"),
    [
        (4, "1"),
        pytest.param(1, "1 -1", marks=pytest.mark.large),
        pytest.param(4, "1 -1", marks=pytest.mark.large),
    ],
)
def test_core_with_a_local_table(fold: int, signs: str) -> None:
    """The core with a local table corrects scratches; ``signs`` has the signs of the tables that
    are loaded one after the other. ``tb/local_table`` tests the table's banks."""
    simulate(
        "arctrue_core",
        "tb.core.local_table_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "FOLD": fold,
            "LOCAL_TABLE": "true",
        },
        environment={"FOLD": str(fold), "SIGNS": signs},
    )
