from __future__ import annotations

import pytest

from tb.core.arctrue_core_bench import CAPTURE_DEPTH, LANES
from tb.support.simulation import simulate


@pytest.mark.slow
def test_core() -> None:
    simulate(
        "arctrue_core",
        "tb.core.arctrue_core_bench",
        generics={"LANES": LANES, "CAPTURE_DEPTH": CAPTURE_DEPTH},
        backend="llvm",
    )
