"""Tests that an edge takes as many clocks from pin to pin as the pages in docs/ state."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from arctrue.gateware.latency import pin_to_pin_clocks, pipeline_clocks
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("fold", "heads"),
    [
        (1, 2),
        pytest.param(8, 2, marks=pytest.mark.large),
        pytest.param(1, 3, marks=pytest.mark.large),
        pytest.param(2, 4, marks=pytest.mark.large),
    ],
)
def test_pin_to_pin(fold: int, heads: int, tmp_path: Path) -> None:
    measured = tmp_path / "measured.json"
    simulate(
        "arctrue_core",
        "tb.core.pin_to_pin_bench",
        generics={"LANES": 8, "CAPTURE_DEPTH": 64, "FOLD": fold, "HEADS": heads},
        environment={"FOLD": str(fold), "HEADS": str(heads), "MEASURED": str(measured)},
    )
    least, most = pin_to_pin_clocks(fold, heads)
    found = json.loads(measured.read_text())
    assert found == {
        "from_pin_to_pin": list(range(least, most + 1)),
        "register_latency": pipeline_clocks(fold, heads),
    }
