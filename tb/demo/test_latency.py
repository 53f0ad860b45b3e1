"""Tests that the demo measures the latencies of Table 1 of the paper."""

import json
from pathlib import Path

from arctrue.generated import number_formats
from arctrue.studies.demo.files import DemoFiles
from tb.support.simulation import simulate


def test_units_take_the_clocks_of_table_1(tmp_path: Path) -> None:
    simulate(
        "latency_harness",
        "tb.demo.latency_bench",
        environment={"ARCTRUE_DEMO_FOLDER": str(tmp_path)},
    )
    measured = json.loads(DemoFiles(tmp_path).latency.read_text())
    assert measured == {
        "phase calculation": 5,
        "harmonic calculation": 20,
        "error compensation": 4,
        "delay line": 25,
    }
    assert measured["delay line"] == number_formats.DELAY_LINE_LATENCY
