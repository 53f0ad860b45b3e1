from __future__ import annotations

from tb.support.simulation import simulate
from tb.top.reset_release_bench import CLOCKS


def test_reset_release() -> None:
    simulate("reset_release", "tb.top.reset_release_bench", generics={"CLOCKS": CLOCKS})
