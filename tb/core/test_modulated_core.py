"""Runs in GHDL the bench of the whole core, whose lanes have amplitudes that follow the motion."""

from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.large
@pytest.mark.parametrize("rotation", ["table", "cordic"])
def test_modulated_core(rotation: str) -> None:
    """The core with MODULATORS equals the models; its lanes compute the cosine by the table or
    by the CORDIC. ``tb/conditions`` and ``sim/tests/instrument/test_modulators.py`` test modulated
    lanes in shorter runs."""
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
