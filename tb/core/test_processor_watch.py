"""Runs the bench of processor_watch in GHDL."""

from tb.support.simulation import simulate


def test_processor_watch() -> None:
    simulate("processor_watch", "tb.core.processor_watch_bench")
