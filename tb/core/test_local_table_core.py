"""Test of the whole core with a local table.

With a pipeline for each lane, ``hidden_effect/test_scratch.py`` runs it as a netlist.
"""

from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.parametrize("fold", [pytest.param(1, marks=pytest.mark.large), 4])
def test_core_with_a_local_table(fold: int) -> None:
    simulate(
        "arctrue_core",
        "tb.core.local_table_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "FOLD": fold,
            "LOCAL_TABLE": "true",
        },
        environment={"FOLD": str(fold)},
        backend="llvm",
    )
