from __future__ import annotations

from tb.support.simulation import simulate
from tb.top.status_leds_bench import HOLD_LOG2


def test_status_leds() -> None:
    simulate("status_leds", "tb.top.status_leds_bench", generics={"HOLD_LOG2": HOLD_LOG2})
