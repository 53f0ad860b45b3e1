"""Tests that only one program at a time uses a serial port, and that late answers are discarded."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import serial

from arctrue.device.console import Console, ConsoleError
from arctrue.device.exclusive_port import other_users
from arctrue.device.load import SentSet, send_coefficients, wait_until_judged
from arctrue.gateware.coefficients import Coefficients

PATIENCE_S = 20.0


class Device(threading.Thread):
    """A device that answers each line: ``answer`` returns the seconds to wait and then the
    output."""

    def __init__(self, answer: Callable[[str], tuple[float, str]]) -> None:
        super().__init__(daemon=True)
        self.answer = answer
        self.near, self.far = pty.openpty()
        tty.setraw(self.far)
        self.port = os.ttyname(self.far)
        self.lines: list[str] = []
        self.start()

    def run(self) -> None:
        waiting = b""
        while True:
            try:
                waiting += os.read(self.near, 256)
            except OSError:
                return
            *lines, waiting = waiting.split(b"\r")
            for line in filter(None, lines):
                self.lines.append(line.decode())
                seconds, said = self.answer(line.decode())
                time.sleep(seconds)
                os.write(self.near, said.encode())


def firmware_like(line: str) -> tuple[float, str]:
    """Return the console's answer: the state for ``load status``, ``ok`` for every other load
    command and for help, and the error message for any other line."""
    if line == "load status":
        return 0.0, "load active\r\nloaded_order 3\r\nok\r\n"
    if line.startswith(("load", "help")):
        return 0.0, "ok\r\n"
    return 0.0, f"error: no such command, try help: {line}\r\n"


@pytest.fixture
def device() -> Iterator[Device]:
    made = Device(firmware_like)
    yield made
    os.close(made.far)
    # The thread must end here: otherwise it would read the port of the next test, which gets the
    # same file descriptor.
    made.join(PATIENCE_S)
    os.close(made.near)


HOLD = """
import sys, time
from arctrue.device.console import Console
console = Console(sys.argv[1])
print("open", flush=True)
time.sleep(60)
"""
LISTEN = """
import os, sys, time
port = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
print("open", flush=True)
time.sleep(60)
"""


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs Linux' /proc")
@pytest.mark.parametrize("program", [HOLD, LISTEN], ids=["arctrue", "any other"])
def test_a_port_that_another_program_has_is_refused_with_its_name(
    program: str, tmp_path: Path
) -> None:
    """The console refuses a port that another program uses and names this program. Two programs
    would each receive parts of the lines."""
    near, far = pty.openpty()
    port = os.ttyname(far)
    os.close(far)
    file = tmp_path / "other.py"
    file.write_text(program, encoding="utf-8")
    command = [sys.executable, str(file), port]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as other:
        try:
            assert other.stdout is not None
            assert other.stdout.readline() == b"open\n"
            start = time.monotonic()
            with pytest.raises(ConsoleError, match=r"is in use by .*/other\.py ") as raised:
                Console(port)
            assert time.monotonic() - start < 5.0
            assert f"(process {other.pid})" in str(raised.value)
        finally:
            other.kill()
    Console(port).close()
    os.close(near)


def test_the_same_program_does_not_open_it_twice(device: Device) -> None:
    console = Console(device.port)
    with pytest.raises(ConsoleError, match="is in use"):
        Console(device.port)
    console.close()
    Console(device.port).close()


@pytest.mark.skipif(os.getuid() == 0, reason="the administrator opens any port")
def test_who_asks_for_no_lock_is_kept_out_too(device: Device) -> None:
    console = Console(device.port)
    with pytest.raises(OSError, match="busy"):
        os.open(device.port, os.O_RDWR | os.O_NOCTTY)
    console.close()
    os.close(os.open(device.port, os.O_RDWR | os.O_NOCTTY))


def test_a_port_without_a_terminal_is_opened() -> None:
    assert other_users("loop://") == []
    Console("loop://").close()
    assert serial.serial_for_url("loop://", exclusive=True).is_open


def test_an_answer_that_comes_late_is_not_taken_for_the_next_ones(
    device: Device, caplog: pytest.LogCaptureFixture
) -> None:
    def slow_once(line: str) -> tuple[float, str]:
        if line == "slow":
            return 1.5, "answer to slow\r\nok\r\n"
        return (0.0, "answer to fast\r\nok\r\n") if line == "fast" else firmware_like(line)

    device.answer = slow_once
    console = Console(device.port, timeout_s=0.1)
    with pytest.raises(ConsoleError, match="no answer to 'slow'"):
        console.command("slow", 0.5)
    assert console.command("fast", PATIENCE_S) == ["answer to fast"]
    assert "2 late lines that no command waits for are dropped" in caplog.text
    console.close()


def test_what_another_program_has_asked_for_is_left_out(device: Device) -> None:
    """The console ignores the device's answer to an earlier program that ended in the middle of a
    line."""
    os.write(device.far, b"load status\rload la")
    time.sleep(0.1)
    console = Console(device.port, timeout_s=0.1)
    os.write(device.near, b"ok\r\n")
    assert console.command("load status", PATIENCE_S) == ["load active", "loaded_order 3"]
    console.close()


def test_a_line_that_comes_in_two_parts_is_one_line(device: Device) -> None:
    """The console joins the two parts of a line between which the device pauses for longer than one
    read waits."""
    console = Console(device.port, timeout_s=0.05)
    device.answer = lambda line: (0.0, "load act") if line == "load" else firmware_like(line)
    rest = threading.Timer(0.5, os.write, (device.near, b"ive\r\nok\r\n"))
    console.command("help", PATIENCE_S)
    rest.start()
    assert console.command("load", PATIENCE_S) == ["load active"]
    console.close()


def test_a_load_whose_first_answer_is_late_ends_well(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A load ends well although its first answer is late. An earlier version took the late ok for
    the load's state and ended with `not enough values to unpack`."""
    answers = iter([1.5])

    def late_once(line: str) -> tuple[float, str]:
        seconds, said = firmware_like(line)
        return (next(answers, 0.0) if line.startswith("load begin") else seconds), said

    device.answer = late_once
    monkeypatch.setattr(Console.command, "__defaults__", (0.5,))
    console = Console(device.port, timeout_s=0.1)
    coefficients = Coefficients.from_harmonics([3], [10.0], [0.5], 1 << 20, 4)
    sent = send_coefficients(console, coefficients, lambda *_: None)
    wait_until_judged(console, sent, PATIENCE_S)
    console.close()


def test_an_answer_that_is_none_is_reported(device: Device) -> None:
    def other(line: str) -> tuple[float, str]:
        return (0.0, "ok\r\n") if line == "load status" else firmware_like(line)

    device.answer = other
    console = Console(device.port, timeout_s=0.1)
    with pytest.raises(ConsoleError, match="expected one"):
        wait_until_judged(console, SentSet(0, ()), PATIENCE_S)
    console.close()
