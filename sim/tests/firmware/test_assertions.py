"""Tests that a failed assertion ends the process on this machine; on the chip it raises a fault,
see test_qemu.py."""

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
    """A step with an impossible state ends the process. The limits are 64 lanes (limits.h) and the
    last members of the enumerations."""
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


CALL = """
from sim.tests.firmware.library import firmware
ffi, library = firmware()
print("prepared", flush=True)
{call}
"""


@pytest.mark.parametrize(
    ("call", "condition"),
    [
        (
            "library.coefficients_most_order(ffi.new('struct coefficients *', {'lanes': 65}))",
            "coefficients->lanes",
        ),
        ("library.coefficients_phase_step(1, 0)", "counts_per_rev"),
        (
            "library.average_add(ffi.new('struct average *'), "
            "ffi.new('struct estimate *', {'orders': 41}), 0.5)",
            "turn->orders",
        ),
        ("library.estimate_is_finite(ffi.new('struct estimate *', {'orders': 41}))", "->orders"),
        ("library.index_uncertainty_rad(0, 0.1)", "counts_per_rev"),
        ("library.text_fixed(ffi.new('struct text_sink *'), 1.0, 10)", "decimals"),
        ("library.text_word(ffi.new('struct text_sink *'), ffi.NULL)", "word"),
        (
            "library.console_receive(ffi.new('struct console *', {'length': 81}), 32)",
            "console->length",
        ),
        (
            "library.console_step(ffi.new('struct console *', {'application': "
            "ffi.new('struct application *'), 'dump_place': 2, 'dump_end': 1}))",
            "console->dump_place",
        ),
    ],
)
def test_a_call_that_must_never_be_ends_the_process(call: str, condition: str) -> None:
    """A call with impossible arguments ends the process. The limits of calibration and console are
    40 orders, 64 lanes, 80 characters per line and 9 decimals."""
    ended = subprocess.run(
        [sys.executable, "-c", CALL.format(call=call)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "prepared" in ended.stdout, ended.stderr
    assert ended.returncode == -signal.SIGABRT, ended.stderr
    assert "assertion fails" in ended.stderr
    assert condition in ended.stderr
