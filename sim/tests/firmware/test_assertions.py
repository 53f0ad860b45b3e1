"""What must never be ends the process on this machine; on the chip it is a fault, test_qemu.py."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest
from sim.tests.firmware.library import ROOT

PREPARE = """
from sim.tests.firmware.library import firmware
ffi, library = firmware()
application = ffi.new("struct application *")
library.application_prepare(application, ffi.new("struct core_access *"))
library.application_step(application)
print("prepared", flush=True)
application.{change}
library.application_step(application)
"""


@pytest.mark.parametrize(
    ("change", "condition"),
    [
        ("phase = 99", "application->phase"),
        (
            "phase, application.configuration.lanes = library.PHASE_HELD, 65",
            "application->configuration.lanes",
        ),
        ("active.lanes = 65", "application->active.lanes"),
        ("has_active = application.inherited = True", "application->inherited"),
        ("saved_state = library.SAVED_WAITING", "application->saved_state"),
        ("load.state = 99", "load->state"),
        ("load.loaded.lanes = 65", "load->loaded.lanes"),
        ("load.whole = True", "load->whole"),
    ],
)
def test_a_state_that_must_never_be_ends_the_step(change: str, condition: str) -> None:
    """64 lanes (limits.h) and the enumerations' last members are the bounds."""
    ended = subprocess.run(
        [sys.executable, "-c", PREPARE.format(change=change)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "prepared" in ended.stdout, ended.stderr
    assert ended.returncode == -signal.SIGABRT, ended.stderr
    assert "assertion fails" in ended.stderr
    assert condition in ended.stderr
