"""Runs ``arctrue device run`` as a separate process, with a device that replays telemetry."""

from __future__ import annotations

import json
import os
import pty
import queue
import signal
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from arctrue.device.announcement import Announcement, announced

PROGRAM = "from arctrue.cli import main; main()"
PATIENCE_S = 60.0
"""Longest wait for an event in seconds, long enough for a busy machine; tests measure no durations
with it."""


class Replay:
    """The device's end of a pseudo-terminal; the test writes the device's output."""

    def __init__(self) -> None:
        self.end, far = pty.openpty()
        tty.setraw(far)
        self.port = os.ttyname(far)
        os.close(far)  # only one program may use the port
        os.set_blocking(self.end, False)
        self.received: queue.Queue[bytes] = queue.Queue()
        self._pulled = False
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        while not self._pulled:
            try:
                self.received.put(os.read(self.end, 4096))
            except OSError:  # nothing was sent, or no program has the port open
                time.sleep(0.005)

    def send(self, data: bytes) -> None:
        end = time.monotonic() + PATIENCE_S
        while data:
            try:
                data = data[os.write(self.end, data) :]
            except BlockingIOError:
                assert time.monotonic() < end, "nobody reads the port"
                time.sleep(0.001)

    def turn(self, number: int, **fields: Any) -> None:
        self.send(line_of(number, **fields))

    def pull(self) -> None:
        """Close the port like a pulled cable, so that its reader gets an error."""
        self._pulled = True
        self._reader.join()
        os.close(self.end)


def line_of(number: int, **fields: Any) -> bytes:
    made = {"turn": number, "time_s": 1.0 * number, "result": "kept", "reason": "none", "swaps": 0}
    made |= {"temperature_c": 40.5, "alarms": [], "harmonics": [[1, 150.0, 0.4, 0.01, 1]]}
    return json.dumps(made | fields).encode() + b"\r\n"


class Running:
    """A running program; ``said`` contains its messages."""

    def __init__(self, process: subprocess.Popen[str], store: Path) -> None:
        self.process, self.store = process, store
        self.said: list[str] = []
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.said.append(line)

    def heard(self, text: str) -> None:
        def is_said() -> bool:
            assert self.process.poll() is None, self.said
            return any(text in line for line in self.said)

        until(is_said, lambda: f"{text}: {self.said}")

    def writers(self) -> list[int]:
        """Return the process that writes the daily files, if there is one."""
        number = self.process.pid
        return list(map(int, Path(f"/proc/{number}/task/{number}/children").read_text().split()))

    def kill_with_writer(self) -> None:
        """Kill the daemon and the process that writes its daily files, like a power cut."""
        writers = self.writers()
        assert writers
        for writer in writers:
            os.kill(writer, signal.SIGKILL)
        self.process.kill()
        self.process.wait(PATIENCE_S)


def until(is_true: Callable[[], object], message: Callable[[], str] = lambda: "") -> None:
    end = time.monotonic() + PATIENCE_S
    while not is_true():
        assert time.monotonic() < end, message()
        time.sleep(0.02)


@contextmanager
def daemon(port: str, store: Path, *options: str, before: str = "") -> Iterator[Running]:
    """Run a daemon at a free TCP port; its process first executes the Python code ``before``."""
    command = [sys.executable, "-c", before + PROGRAM, "device", "run", port]
    process = subprocess.Popen(
        [*command, "--store", str(store), "--tcp-port", "0", *options],
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    running = Running(process, store)
    try:
        running.heard("serving 127.0.0.1")
        yield running
    finally:
        process.kill()
        process.wait(PATIENCE_S)


def announcement(port: str) -> Announcement:
    found = announced(port)
    assert found is not None
    return found
