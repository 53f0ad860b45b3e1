"""Tests that no change is lost when several commands change one model file at the same time."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from sim.tests.workbench.small_sets import measurement_set

from arctrue.measurement import write_measurement_set
from arctrue.workbench.model.model_file import read_model

COMMAND = "from arctrue.cli import main; main()"
ADDED = ("hysteresis", "subdivision_error", "timing_skew")


@pytest.mark.large
def test_three_parallel_additions_keep_three_effects(tmp_path: Path) -> None:
    folder, model = tmp_path / "set", tmp_path / "table.toml"
    write_measurement_set(folder, measurement_set(cycles=2, turns=1))
    started = [
        subprocess.Popen(
            [sys.executable, "-c", COMMAND, "add", name, str(folder), "--model", str(model)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        for name in ADDED
    ]
    for process in started:
        reported, _ = process.communicate()
        assert process.returncode == 0, reported
    found = read_model(model)
    assert sorted(found.names()) == sorted(["graduation_harmonics", *ADDED])
    # The history has a row for the first fit and one for each effect; no step is lost.
    assert [step.action for step in found.history] == ["fit", "add", "add", "add"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["set", "table.toml"]
