"""Runs ``make generate`` before any test if a source is newer than the generated files."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Tests run in parallel; more threads of the linear algebra (OpenBLAS) would only slow them down.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Examples of hypothesis have no time limit, because their duration depends on the load of the
# machine and on compilations of C. The profile "repeatable" uses the same examples in every run;
# --hypothesis-profile=search draws new examples in every run.
settings.register_profile(
    "search", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True
)
settings.register_profile(
    "repeatable", settings.get_profile("search"), derandomize=True, database=None
)
settings.load_profile("repeatable")

ROOT = Path(__file__).resolve().parent
STAMP = ROOT / "build" / "generated" / ".made"  # the Makefile uses this file too
SOURCES = (
    *(
        ROOT / "scripts" / name
        for name in ("generate.py", "generate_python.py", "number_formats.py", "register_map.py")
    ),
    ROOT / "rtl" / "formats" / "number_formats_pkg.vhd",
    *sorted((ROOT / "rtl" / "registers").glob("*.rdl")),
)
MADE = ROOT / "sim" / "arctrue" / "generated" / "number_formats.py"


def pytest_configure(config: pytest.Config) -> None:
    """Generate the outputs if a source is newer, once, before the workers of xdist start."""
    if hasattr(config, "workerinput"):
        return
    if MADE.exists() and STAMP.exists():
        made = STAMP.stat().st_mtime
        if all(source.stat().st_mtime <= made for source in SOURCES):
            return
    done = subprocess.run(
        [sys.executable, "-m", "scripts.generate"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        pytest.exit(
            f"The generated files are out of date and cannot be made; see 'make generate':\n"
            f"{done.stdout}{done.stderr}",
            returncode=4,
        )
    STAMP.touch()
