"""Runs in GHDL the bench of the whole core, whose lanes have amplitudes that follow the motion."""

from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("rotation", "up_turns"),
    [
        ("table", 2),
        pytest.param("table", 12, marks=pytest.mark.large),
        pytest.param("cordic", 12, marks=pytest.mark.large),
    ],
)
def test_modulated_core(rotation: str, up_turns: int) -> None:
    """The core with MODULATORS equals the models; its lanes compute the cosine by the table or, in
    a large test, by the CORDIC. The measured speed is that of the table after 12 turns; two turns
    are too few for a window of the speed (``tb/conditions`` tests the speed)."""
    simulate(
        "arctrue_core",
        "tb.core.modulated_core_bench",
        generics={
            "LANES": LANES,
            "CAPTURE_DEPTH": CAPTURE_DEPTH,
            "MODULATORS": "true",
            "ROTATION": rotation,
        },
        environment={"ROTATION": rotation, "UP_TURNS": str(up_turns)},
    )
