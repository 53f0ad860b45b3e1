from __future__ import annotations

from tb.support.simulation import simulate


def test_bridge() -> None:
    simulate("axi3_to_axi_lite", "tb.top.axi3_to_axi_lite_bench")
