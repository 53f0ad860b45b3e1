"""Runs one of the demo's simulations: ``python -m tb.demo.simulator PART FOLDER``."""

from __future__ import annotations

import sys
from pathlib import Path

from arctrue.studies.demo.files import DemoFiles
from arctrue.studies.demo.settings import DemoSettings
from tb.support.simulation import simulate


def run_core(files: DemoFiles) -> None:
    """Simulate the whole core with the edges of the table's heads."""
    settings = DemoSettings.read(files.settings)
    simulate(
        "demo_harness",
        "tb.demo.demo_bench",
        generics={
            "LANES": settings.lanes,
            "CAPTURE_DEPTH": settings.capture_depth,
            "PLAYED": str(files.played),
            "RECORDED": str(files.recorded),
        },
        environment={"ARCTRUE_DEMO_FOLDER": str(files.folder)},
    )


def run_latency(files: DemoFiles) -> None:
    """Simulate a step of the angle through the units of the compensation."""
    simulate(
        "latency_harness",
        "tb.demo.latency_bench",
        environment={"ARCTRUE_DEMO_FOLDER": str(files.folder)},
    )


if __name__ == "__main__":
    part, folder = sys.argv[1:]
    {"core": run_core, "latency": run_latency}[part](DemoFiles(Path(folder)))
