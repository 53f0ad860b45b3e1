"""Tests that the import of a long recording needs only a limited memory per row."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
import pytest

ROWS = 1_000_000
MOST_BYTES_A_ROW = 1e9 / 5e6 - 30.0
"""Largest number of bytes per row: 5 · 10⁶ rows must fit into 1 GB, of which the program takes 150
MB (30 bytes per row)."""
_PEAK = """
import resource, sys
from arctrue.cli import main
main(sys.argv[1:], standalone_mode=False)
print("peak", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)
"""


def _peak_bytes(path: Path, rows: int, out: Path) -> int:
    turn = np.linspace(0.0, 720.0, rows // 2)
    angle = np.round(np.concatenate([turn, turn[::-1]]), 6)
    head1 = np.round(angle + 1e-3 * np.sin(np.deg2rad(angle)), 6)
    columns = {"time_s": np.arange(rows) * 1e-3, "target_deg": angle, "head1_deg": head1}
    pa_csv.write_csv(pa.table(columns), path)
    done = subprocess.run(
        [sys.executable, "-c", _PEAK, "import", str(path), str(out)],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    return int(done.stdout.split()[-1])


@pytest.mark.large
def test_the_memory_of_an_import(tmp_path: Path) -> None:
    few = _peak_bytes(tmp_path / "few.csv", 1000, tmp_path / "few")
    many = _peak_bytes(tmp_path / "many.csv", ROWS, tmp_path / "many")
    assert (many - few) / ROWS < MOST_BYTES_A_ROW
