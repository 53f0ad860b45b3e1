"""Runs the processor in QEMU without a program, with its console open."""

from __future__ import annotations

import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

SECONDS = 60.0
"""Longest wait for output of the console; a start takes far less, even on a busy machine."""


class EmptyChip:
    """Emulated processor; ``debugger`` is the path of the socket for gdb."""

    def __init__(self, console: socket.socket, debugger: Path) -> None:
        self.console = console
        self.debugger = debugger

    def wait_for(self, text: bytes) -> bytes:
        """Wait until the output of the console contains ``text``; return the whole output."""
        said = b""
        while text not in said:
            try:
                data = self.console.recv(4096)
            except TimeoutError:
                raise TimeoutError(f"waited for {text!r}, heard {said!r}") from None
            assert data, f"the emulator ended; heard {said!r}"
            said += data
        return said


@contextmanager
def empty_chip(folder: Path, *options: str) -> Iterator[EmptyChip]:
    """Start the emulator with further ``options``, and stop it when the ``with`` block ends."""
    console, debugger = folder / "console", folder / "debugger"
    command = ["qemu-system-arm", "-M", "xilinx-zynq-a9", "-m", "2G", "-nographic"]
    command += ["-monitor", "none", "-serial", f"unix:{console},server=on,wait=on"]
    command += ["-gdb", f"unix:{debugger},server=on,wait=off", *options]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    try:
        with socket.socket(socket.AF_UNIX) as port:
            port.settimeout(SECONDS)
            end = time.monotonic() + SECONDS
            while True:
                try:
                    port.connect(str(console))
                    break
                except OSError:
                    assert process.poll() is None
                    assert time.monotonic() < end
                    time.sleep(0.05)
            while not debugger.exists():
                assert time.monotonic() < end
                time.sleep(0.05)
            yield EmptyChip(port, debugger)
    finally:
        process.kill()
        process.wait()
