"""Runs seven test modules of the firmware once more with AddressSanitizer.

In each ``make test``, ``test_fuzz_corpus.py`` already runs the console and the checks of captures
and records with AddressSanitizer.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
MODULES = (
    *("test_capture.py", "test_coefficients.py", "test_application.py", "test_console.py"),
    *("test_fabric.py", "test_temperature.py", "test_pins.py"),
)


@pytest.mark.large
def test_with_address_sanitizer() -> None:
    preload = subprocess.run(
        ["gcc", "-print-file-name=libasan.so"],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    ).stdout.strip()
    environment = {
        **os.environ,
        "LD_PRELOAD": preload,
        "ARCTRUE_SANITIZE": "address",
        # AddressSanitizer must not report leaks, because Python itself does not free all of its
        # memory.
        "ASAN_OPTIONS": "detect_leaks=0",
    }
    environment.pop("PYTEST_XDIST_WORKER", None)
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-p"]
    command += ["no:xdist", *[str(HERE / module) for module in MODULES]]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        env=environment,
        cwd=HERE.parents[2],
        check=False,
        timeout=1200,
    )
    assert done.returncode == 0, f"{done.stdout[-6000:]}\n{done.stderr[-2000:]}"
