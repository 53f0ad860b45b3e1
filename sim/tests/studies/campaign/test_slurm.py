"""Tests that each job of a Slurm array runs the shard (part of the tasks) with the job's number,
and that the script refuses to run outside of an array."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[4]
SCRIPT = ROOT / "scripts" / "benchmark_array.sbatch"


def job(tmp_path: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    stand_in = tmp_path / "arctrue"
    stand_in.write_text('#!/bin/sh\necho "$OPENBLAS_NUM_THREADS:" "$@"\n')
    stand_in.chmod(0o755)
    clean = {name: value for name, value in os.environ.items() if not name.startswith("SLURM")}
    return subprocess.run(
        ["bash", str(SCRIPT), "sets"],
        env={**clean, "ARCTRUE": str(stand_in), **environment},
        capture_output=True,
        text=True,
        check=False,
    )


def test_each_job_takes_its_shard(tmp_path: Path) -> None:
    said = [
        job(tmp_path, SLURM_ARRAY_TASK_ID=str(n), SLURM_ARRAY_TASK_COUNT="3").stdout for n in (1, 3)
    ]
    assert said == [f"1: benchmark run sets --workers 1 --shard {n}/3\n" for n in (1, 3)]


def test_outside_of_an_array_it_says_so(tmp_path: Path) -> None:
    done = job(tmp_path)
    assert done.returncode != 0
    assert "run it as an array" in done.stderr
