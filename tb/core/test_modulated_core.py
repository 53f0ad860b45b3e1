"""Runs the bench of the whole core with lanes that follow the motion in GHDL."""

from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.parametrize("rotation", ["table", pytest.param("cordic", marks=pytest.mark.large)])
def test_modulated_core(rotation: str) -> None:
    """The core with MODULATORS equals the models; here its lanes use the table, in
    ``tb/conditions`` they use the CORDIC."""
    simulate(
        "arctrue_core",
        "tb.core.modulated_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "MODULATORS": "true",
            "ROTATION": rotation,
        },
        environment={"ROTATION": rotation},
    )
