"""Tests commands in an installation without the packages of an extra. Commands that need no such
package work; the others print one sentence with the install command."""

from __future__ import annotations

import json
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from arctrue.base.extras import EXTRA_OF
from arctrue.measurement import MeasurementSet, Reference, Table, write_measurement_set

# An entry None makes Python's import fail as if the package were not installed.
CORE = f"""
import sys
sys.modules.update(dict.fromkeys({list(EXTRA_OF)}))
from arctrue.cli import main
main()
"""
BAD_INPUT = 2


def in_the_core(*words: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", CORE, *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """Return a folder with one dated reference run over 24 targets."""
    target = np.tile(np.arange(24) * 15.0, 4)
    error = 2.0 * np.cos(np.radians(target)) + 0.05 * np.sin(np.arange(96.0) ** 2)
    rows = Reference(target_deg=target, error_arcsec=error, standard_uncertainty_arcsec=0.1)
    date = datetime(2026, 3, 12, tzinfo=UTC)
    made = MeasurementSet(Table(counts_per_rev=1 << 24), reference=rows, title="a", date=date)
    write_measurement_set(tmp_path / "machine" / "a", made)
    return tmp_path / "machine"


def test_the_history_of_a_machine_needs_no_picture(machine: Path, tmp_path: Path) -> None:
    done = in_the_core("life", machine, "--json", tmp_path / "life.json")
    assert done.returncode == 0, done.stderr
    assert len(json.loads((tmp_path / "life.json").read_text(encoding="utf-8"))["sets"]) == 1
    # The page has a chart; the command states this before it fits the sets.
    done = in_the_core("life", machine, "--out", tmp_path / "page")
    assert done.returncode == BAD_INPUT
    assert "pip install 'arctrue[page]'" in done.stderr
    assert done.stdout == ""


def test_the_budget_needs_no_picture(machine: Path) -> None:
    done = in_the_core("budget", machine / "a")
    assert done.returncode == 0, done.stderr
    assert "νeff" in done.stdout


@pytest.mark.parametrize("command", ["capture", "monitor", "probe", "save"])
def test_a_port_without_pyserial_is_no_fault_of_the_cable(command: str, tmp_path: Path) -> None:
    out = [tmp_path / "set"] if command == "capture" else []
    done = in_the_core(command, "/dev/nowhere", *out)
    assert done.returncode == BAD_INPUT
    said = " ".join(done.stderr.split())
    assert said == "error: this needs serial, which is not installed: pip install 'arctrue[device]'"
