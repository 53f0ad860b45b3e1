"""The ARM image in QEMU, the core's window prepared as plain memory, and its console."""

from __future__ import annotations

import fcntl
import socket
import struct
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sim.tests.firmware.library import FIRMWARE, ROOT

from arctrue.gateware.register_access import register_named

BOARD = "pynq_z2"
IMAGE = ROOT / "build" / "firmware" / BOARD / "arctrue.elf"
CORE_BASE = 0x4000_0000
CAPTURE = 0x20000
BOTH_INDICES_SEEN = 0b11


def build(board: str = BOARD) -> Path:
    """Make the image; raises AssertionError with what the compiler or the size table says."""
    folder = ROOT / "build" / "firmware"
    folder.mkdir(parents=True, exist_ok=True)
    # Two workers of pytest must not make the same image at the same time.
    with (folder / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        command = ["make", "-C", str(FIRMWARE), f"BOARD={board}"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"make firmware:\n{done.stdout}{done.stderr}"
    return ROOT / "build" / "firmware" / board / "arctrue.elf"


def core_window(
    counts: NDArray[np.integer] | None, counts_per_rev: int = 1 << 24, depth: int = 12288
) -> bytes:
    """The registers as the core would show them with one bank ready, counts (2, n)."""
    words = np.zeros(0x40000 // 4, dtype=np.uint32)

    def put(path: str, word: int) -> None:
        words[register_named(path).address // 4] = word & 0xFFFF_FFFF

    put("identification", 0x41524354)
    put("version", 0x000100)
    put("core_configuration", 32 | 18 << 8 | depth << 16)
    put("clock_hz", 100_000_000)
    put("counts_per_rev_active", counts_per_rev)
    if counts is not None:
        put("head1.flags", 1)
        put("head2.flags", 1)
        put("status", 1 << 2)
        put("capture_header.sample_count", counts.shape[1])
        put("capture_header.flags", BOTH_INDICES_SEEN)
        put("snapshot.head1_turn_position", int(counts[0, -1]))
        put("snapshot.head1_position", int(counts[0, -1]))
        put("snapshot.head1_angle", int(counts[0, -1]) % counts_per_rev)
        samples = counts.T.astype(np.int64).astype(np.uint32).ravel()
        words[CAPTURE // 4 : CAPTURE // 4 + samples.size] = samples
    return words.tobytes()


def symbol(name: str) -> int:
    """The address of a function, without the Thumb bit."""
    listing = subprocess.run(
        ["arm-none-eabi-nm", str(IMAGE)], capture_output=True, text=True, check=True
    ).stdout
    (line,) = [entry for entry in listing.splitlines() if entry.split()[-1] == name]
    return int(line.split()[0], 16) & ~1


class Emulator:
    """One run; ``said`` is all that the console has said so far."""

    def __init__(self, console: socket.socket, debugger: Path, process: Any) -> None:
        self.console = console
        self.debugger = debugger
        self.process = process
        self.said = ""

    def wait_for(self, text: str, seconds: float = 20.0, start: int = 0) -> str:
        """What is said from ``start`` on, once ``text`` is part of it."""
        end = time.monotonic() + seconds
        while text not in self.said[start:]:
            left = end - time.monotonic()
            if left <= 0:
                raise TimeoutError(f"waited for {text!r}, heard {self.said[start:]!r}")
            self.console.settimeout(left)
            try:
                data = self.console.recv(4096)
            except TimeoutError:
                continue
            assert data, f"the emulator ended; heard {self.said[start:]!r}"
            self.said += data.decode("ascii")
        return self.said[start:]

    def send(self, line: str, seconds: float = 20.0) -> str:
        """A command and its answer up to the line with ok or error.

        What is told without being asked (telemetry) may follow at once; it is not the answer.
        """
        end = time.monotonic() + seconds
        start = len(self.said)
        self.console.sendall(line.encode() + b"\r")
        while time.monotonic() < end:
            whole = self.said[start:].split("\r\n")[:-1]
            for number, text in enumerate(whole, start=1):
                if text.startswith(("ok", "error")):
                    return "".join(f"{item}\r\n" for item in whole[:number])
            self.wait_for("\r\n", end - time.monotonic(), len(self.said))
        raise TimeoutError(f"no answer to {line!r}, heard {self.said[start:]!r}")

    def ask(self, line: str, expected: str, seconds: float = 20.0) -> str:
        """The command again and again until its answer holds ``expected``.

        Characters are lost while the firmware begins anew.
        """
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                answer = self.send(line, 1.0)
            except TimeoutError:
                continue
            if expected in answer:
                return answer
        raise AssertionError(f"{line}: never heard {expected!r} but {self.said[-3000:]!r}")

    def write_memory(self, address: int, data: bytes) -> None:
        """By the debugger's port, with the processor stopped and let go again."""
        with socket.socket(socket.AF_UNIX) as port:
            port.connect(str(self.debugger))
            port.settimeout(10.0)
            for text in (f"M{address:x},{len(data):x}:{data.hex()}", "D"):
                port.sendall(f"${text}#{sum(text.encode()) % 256:02x}".encode())
                answer = b""
                # The news that the processor has stopped may come first.
                while b"$OK#" not in answer:
                    answer += port.recv(4096)
                    assert b"$E" not in answer, answer
                port.sendall(b"+")


@contextmanager
def running(folder: Path, window: bytes, *options: str, image: Path = IMAGE) -> Iterator[Emulator]:
    """Start the image; it is stopped when the block ends."""
    (folder / "core.bin").write_bytes(window)
    console, debugger = folder / "console", folder / "debugger"
    command = ["qemu-system-arm", "-M", "xilinx-zynq-a9", "-m", "2G", "-nographic"]
    command += ["-kernel", str(image), "-monitor", "none"]
    command += ["-device", f"loader,file={folder}/core.bin,addr={CORE_BASE:#x},force-raw=on"]
    command += ["-serial", f"unix:{console},server=on,wait=on"]
    command += ["-gdb", f"unix:{debugger},server=on,wait=off", *options]
    with (folder / "qemu.log").open("wb") as log:
        process = subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL)
    try:
        with socket.socket(socket.AF_UNIX) as port:
            _connect(port, console, process, folder / "qemu.log")
            yield Emulator(port, debugger, process)
    finally:
        process.kill()
        process.wait()


def _connect(port: socket.socket, path: Path, process: Any, log: Path) -> None:
    end = time.monotonic() + 20.0
    while True:
        try:
            port.connect(str(path))
            return
        except OSError:
            assert process.poll() is None, log.read_text("utf-8", "replace")
            assert time.monotonic() < end, f"no console at {path}"
            time.sleep(0.05)


def word(value: int) -> bytes:
    """Little endian."""
    return struct.pack("<I", value)
