"""Tests of the ARM image in QEMU: start-up, console, timer, faults, and a calibration of realistic
size."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sim.tests.firmware.calibrator import capture_in_c, estimate, values_of
from sim.tests.firmware.emulator import (
    BOARD,
    CORE_BASE,
    IMAGE,
    build,
    core_window,
    machine_code,
    running,
    symbol,
)
from sim.tests.firmware.library import ROOT
from sim.tests.firmware.test_estimates import DISC, EQUAL_TO, counts_of

from arctrue.generated.registers import REGISTERS

pytestmark = [
    pytest.mark.skipif(
        shutil.which("qemu-system-arm") is None or shutil.which("arm-none-eabi-gcc") is None,
        reason="needs qemu-system-arm and gcc-arm-none-eabi; make setup installs them",
    ),
]

GREETING = f"arctrue {BOARD}, help lists the commands\r\n"
WRITTEN = 0.5e-9
"""Largest rounding error of the console, which writes nine decimals."""


@pytest.fixture(scope="module", autouse=True)
def image() -> None:
    build()


@pytest.fixture(scope="module")
def counts() -> Any:
    return counts_of()


def rows_of(answer: str) -> list[list[str]]:
    return [line.split() for line in answer.splitlines()[1:-1]]


@pytest.mark.large
def test_the_other_board_is_built_too() -> None:
    assert build("arty_z7_20").exists()


def test_the_memory_plan_has_the_sizes_of_the_image() -> None:
    """The used bytes in docs/memory-plan.md equal the sizes of the sections within 1 %. The test is
    for the compiler that the page names, because another version makes other code."""
    page = (ROOT / "docs" / "memory-plan.md").read_text(encoding="utf-8")
    compiler = subprocess.run(
        ["arm-none-eabi-gcc", "-dumpversion"], check=True, capture_output=True, text=True
    ).stdout
    if f"(GCC {'.'.join(compiler.split('.')[:2])})" not in page:
        pytest.skip(f"the page is for another compiler than GCC {compiler.strip()}")
    sizes = subprocess.run(
        ["arm-none-eabi-size", "-A", str(IMAGE)], check=True, capture_output=True, text=True
    ).stdout
    size = {
        name: int(number) for name, number in re.findall(r"^(\.[\w.]+) +(\d+)", sizes, re.MULTILINE)
    }
    code = sum(size[name] for name in (".text", ".ARM.exidx", ".pages", ".data"))
    rows = re.findall(r"^\| 0x\w+[^|]* \| [\d,]+ \| ([\d,]+) \|", page, re.MULTILINE)
    stated = [int(number.replace(",", "")) for number in rows]
    used = [code, *(size[name] for name in (".texts", ".stack", ".bss", ".record", ".upper"))]
    assert stated == pytest.approx(used, rel=0.01)


def test_start_up_and_console_without_a_core(tmp_path: Path) -> None:
    with running(tmp_path, bytes(64)) as machine:
        machine.wait_for(GREETING)
        status = machine.send("status")
        assert "phase no_core\r\n" in status
        assert "reset none\r\n" in status
        assert machine.send("xyz").startswith("error: no such command")
        assert machine.send("q" * 3000).startswith("error: the line is too long")
        assert machine.send("freeze on") == "ok\r\n"


@pytest.mark.parametrize("method", ["fourier", "least_squares"])
def test_a_calibration_of_real_size(tmp_path: Path, counts: Any, method: str) -> None:
    """The console prints the same results for 12,000 samples of two heads as the C code on this
    machine."""
    window = bytearray(core_window(counts))
    (flags,) = [r.address for r in REGISTERS if r.path == "head1.flags"]
    # The firmware calculates nothing before it sees the index of head 1, so that the test can set
    # the method first.
    window[flags] = 0
    with running(tmp_path, bytes(window)) as machine:
        machine.wait_for(GREETING)
        machine.send(f"set method {int(method == 'least_squares')}")
        machine.write_memory(CORE_BASE + flags, b"\x01")
        machine.ask("status", "phase swap", 60.0)
        rows = rows_of(machine.send("show harmonics"))
        heads = rows_of(machine.send("show heads"))
    found = np.array([[float(v) for v in row[1:3]] for row in rows]).T.ravel()
    _, made = estimate(method, capture_in_c(counts))
    if method == "fourier":
        from sim.tests.firmware.library import firmware

        ffi, library = firmware()
        library.estimate_as_function_of_reading(ffi.new("struct reading_workspace *"), made)
    largest = np.hypot(*values_of(made).reshape(2, -1)).max() / 2.0
    assert np.abs(found - values_of(made)).max() < EQUAL_TO * largest + WRITTEN
    # The place of head 2 is the integral of the difference over head 1's reading; the console
    # prints 1e-6 degrees.
    turn = 1 << 24
    one, apart = counts[0].astype(float), (counts[1] - counts[0]).astype(float)
    closed = np.append(one, one[0] + turn), np.append(apart, apart[0])
    place = np.trapezoid(closed[1], closed[0]) / turn * 360.0 / turn
    assert [row[5:7] for row in heads] == [["turn", "1"], ["turn", "2"]]
    assert float(heads[1][3]) == pytest.approx(place, abs=1e-6)
    applied = {int(row[0]) for row in rows if row[4] == "applied"}
    assert applied >= set(DISC.orders) - {11, 31}


def test_telemetry_and_timer(tmp_path: Path, counts: Any) -> None:
    """The timer alone wakes the firmware: it processes the bank, which the test leaves ready, and
    sends telemetry."""
    with running(tmp_path, core_window(counts[:, :1])) as machine:
        machine.wait_for(GREETING)
        machine.send("telemetry on")
        telemetry = machine.wait_for('"turn":')
        assert '"result":"refused","reason":"short_of_a_turn"' in machine.wait_for("}\r\n"), (
            telemetry
        )


@pytest.mark.parametrize(
    ("code", "name"),
    [
        # udf.w #0
        pytest.param(bytes.fromhex("f0f700a0"), "undefined_instruction", marks=pytest.mark.large),
        # udf #0xA5: a failed assertion executes this instruction.
        (bytes.fromhex("a5de"), "assertion"),
        # mov.w r0, #0xD0000000; ldr r0, [r0]: nothing is mapped at this address.
        (bytes.fromhex("4ff050400068"), "data_abort"),
        # mov.w r0, #0x31000; str r0, [r0]: this page is below the stack.
        (bytes.fromhex("4ff444300060"), "stack_overflow"),
        # mov.w r0, #0xE0000000; ldr r0, [r0]: the bus address of the UART, which the page table
        # does not map.
        pytest.param(bytes.fromhex("4ff060400068"), "data_abort", marks=pytest.mark.large),
        # mov.w r0, #0x1C000; str r0, [r0]: constants are read only.
        pytest.param(bytes.fromhex("4ff4e0300060"), "data_abort", marks=pytest.mark.large),
        # mov.w r0, #0x1C000; bx r0: constants cannot be executed.
        pytest.param(bytes.fromhex("4ff4e0300047"), "prefetch_abort", marks=pytest.mark.large),
        # mov.w r0, #0x22000; bx r0: data cannot be executed.
        (bytes.fromhex("4ff408300047"), "prefetch_abort"),
    ],
)
def test_faults_leave_the_core_and_begin_anew(
    tmp_path: Path, counts: Any, code: bytes, name: str
) -> None:
    with running(tmp_path, core_window(None)) as machine:
        machine.wait_for(GREETING)
        original = machine_code(symbol("application_step"), len(code))
        machine.write_memory(symbol("application_step"), code)
        machine.wait_for(f"fault {name} at 0x")
        machine.write_memory(symbol("application_step"), original)
        machine.ask("status", f"reset {name}\r\n")
