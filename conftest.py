"""Before any test: what scripts/generate.py makes must be as new as what it is made of."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

# Tests run side by side: threads of the linear algebra would only fight for the cores.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ROOT = Path(__file__).resolve().parent
STAMP = ROOT / "build" / "generated" / ".made"  # the Makefile's too
SOURCES = (
    ROOT / "scripts" / "generate.py",
    ROOT / "rtl" / "formats" / "number_formats_pkg.vhd",
    *sorted((ROOT / "rtl" / "registers").glob("*.rdl")),
)
MADE = ROOT / "sim" / "arctrue" / "generated" / "number_formats.py"


def pytest_configure(config: pytest.Config) -> None:
    """Generate anew when a source is newer; once, before the workers of xdist start."""
    if hasattr(config, "workerinput"):
        return
    if MADE.exists() and STAMP.exists():
        made = STAMP.stat().st_mtime
        if all(source.stat().st_mtime <= made for source in SOURCES):
            return
    done = subprocess.run(
        [sys.executable, str(ROOT / "scripts" / "generate.py")],
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
