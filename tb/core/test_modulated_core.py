"""The whole core with lanes that follow the direction of motion and the speed."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize("fold", [2])
def test_modulated_core(fold: int) -> None:
    simulate(
        "arctrue_core",
        "tb.core.modulated_core_bench",
        generics={"LANES": 4, "CAPTURE_DEPTH": 64, "FOLD": fold, "MODULATORS": "true"},
        environment={"FOLD": str(fold)},
        backend="llvm",
    )
