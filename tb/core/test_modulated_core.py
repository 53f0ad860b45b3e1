"""Test of the whole core with lanes that follow the motion."""

from __future__ import annotations

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


def test_modulated_core() -> None:
    simulate(
        "arctrue_core",
        "tb.core.modulated_core_bench",
        generics={"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH, "MODULATORS": "true"},
        backend="llvm",
    )
