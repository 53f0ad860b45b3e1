"""Tests that an edge takes as many clocks from pin to pin as the pages in docs/ state."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from arctrue.gateware.latency import pin_to_pin_clocks
from tb.support.simulation import simulate


@pytest.mark.parametrize("fold", [1, pytest.param(8, marks=pytest.mark.large)])
def test_pin_to_pin(fold: int, tmp_path: Path) -> None:
    measured = tmp_path / "measured.json"
    simulate(
        "arctrue_core",
        "tb.core.pin_to_pin_bench",
        generics={"LANES": 8, "CAPTURE_DEPTH": 64, "FOLD": fold},
        environment={"FOLD": str(fold), "MEASURED": str(measured)},
    )
    least, most = pin_to_pin_clocks(fold)
    assert json.loads(measured.read_text()) == list(range(least, most + 1))
