"""Writes the daily files in a process of its own.

After a failed write, for example on a full disk, HDF5 can neither close the file nor end without a
segmentation fault. The writer then ends at once, and the daemon starts another one. If the daemon
is killed, the writer closes the file.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
import sqlite3
import sys
import time
from asyncio.subprocess import PIPE, Process
from pathlib import Path
from typing import Any

from arctrue.device.daemon.live_day import LiveDays
from arctrue.device.daemon.store_lock import StoreLock
from arctrue.device.nexus_days import UnfinishedFileError, hdf5_reason
from arctrue.device.port import ConsoleError

PATIENCE_S = 10.0
"""Time in seconds during which a writer waits until an earlier one has closed its file."""
END_S = 60.0
"""Longest time in seconds for the last update at the daemon's end; systemd waits 90 s."""


_LONGEST_ANSWER = 1 << 24
"""Largest length of an answer in bytes; an answer names every file that was written."""


class DayWriterError(Exception):
    """Raised if the daily files could not be written; the message contains the reason."""


class DayWriter:
    """Starts and controls, in the daemon, the process that writes the daily files."""

    def __init__(self, record: Path, folder: Path) -> None:
        """Start nothing: the first update starts the process."""
        self._record, self._folder = record, folder
        self._process: Process | None = None
        self._in_use = asyncio.Lock()

    async def update(self, *, exceeded: bool) -> tuple[list[str], int]:
        """Update the files as LiveDays.update does; return the written files and the largest id of
        a turn that may be deleted. Raises DayWriterError."""
        async with self._in_use:
            return await self._update(exceeded)

    async def _update(self, exceeded: bool) -> tuple[list[str], int]:
        if self._process is None:
            self._process = await self._started()
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        with contextlib.suppress(ConnectionError):
            process.stdin.write(json.dumps({"exceeded": exceeded}).encode() + b"\n")
            await process.stdin.drain()
        try:
            answer = _answer_in(await process.stdout.readline())
        except ValueError as error:
            self._process = None
            await _kill(process)
            raise DayWriterError(f"the writer's answer is not JSON: {error}") from error
        if "written" not in answer:
            self._process = None
            raise DayWriterError(answer.get("error") or _end_of(await process.wait()))
        return answer["written"], answer["deletable"]

    async def _started(self) -> Process:
        command = (sys.executable, "-m", "arctrue.device.daemon.day_writer")
        try:
            return await asyncio.create_subprocess_exec(
                *command,
                str(self._record),
                str(self._folder),
                stdin=PIPE,
                stdout=PIPE,
                limit=_LONGEST_ANSWER,
                start_new_session=True,  # Ctrl-C would end the writer while it starts
            )
        except OSError as error:
            raise DayWriterError(f"the writer cannot be started: {error}") from error

    async def close(self) -> None:
        """Append the last turns and close the files. Raises DayWriterError."""
        async with self._in_use:
            await self._close()

    async def _close(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.close()
        try:
            async with asyncio.timeout(END_S):
                lines = (await process.stdout.read()).splitlines()
                ended = await process.wait()
        except TimeoutError:
            await _kill(process)
            raise DayWriterError(f"the writer was ended after {END_S:.0f} s") from None
        if ended:
            raise DayWriterError(_last_error(lines) or _end_of(ended))


def _answer_in(line: bytes) -> dict[str, Any]:
    """Return an answer; an empty one for an incomplete line, during which the writer has ended.
    Raises ValueError."""
    if not line.endswith(b"\n"):
        return {}
    try:
        answer = json.loads(line)
    except ValueError:
        answer = None
    if not isinstance(answer, dict) or answer.keys().isdisjoint(("written", "error")):
        raise ValueError(line.decode("utf-8", "replace").strip())
    return answer


def _last_error(lines: list[bytes]) -> str:
    try:
        return str(_answer_in(lines[-1] + b"\n").get("error", "")) if lines else ""
    except ValueError as error:
        return f"the writer's answer is not JSON: {error}"


def _end_of(code: int) -> str:
    if code < 0:
        return f"the writer was killed by signal {-code}"
    return f"the writer ended with exit code {code}"


async def _kill(process: Process) -> None:
    """Kill the writer and wait for its end, after which its lock is free."""
    with contextlib.suppress(ProcessLookupError):
        process.kill()
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(PATIENCE_S):
            await process.wait()


def main() -> None:
    """Answer every line of the standard input with a line of JSON; at its end, close the files."""
    # systemd and a closing terminal send signals to all processes; the daemon decides when its
    # writer ends.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    record, folder = map(Path, sys.argv[1:])
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _lock(folder)
        for unfinished in folder.glob(".arctrue-????-??-??.*"):
            unfinished.unlink()  # of a writer that was killed
        days = LiveDays(record, folder)
        for line in sys.stdin:
            done = days.update(exceeded=json.loads(line)["exceeded"])
            _answer({"written": [str(path) for path in done.written], "deletable": done.deletable})
        days.close()
    except Exception as error:
        # A day's file of another program can lead to any error.
        _answer({"error": _reason(error)})
        os._exit(1)


def _reason(error: Exception) -> str:
    if isinstance(error, (RuntimeError, UnfinishedFileError)):
        return hdf5_reason(error)
    named = isinstance(error, (ConsoleError, OSError, sqlite3.Error))
    return str(error) if named else f"{type(error).__name__}: {error}"


def _lock(folder: Path) -> StoreLock:
    end_s = time.monotonic() + PATIENCE_S
    while True:
        try:
            return StoreLock.of_files(folder, "arctrue device run", "name another folder: --files")
        except ConsoleError:
            if time.monotonic() >= end_s:
                raise
        time.sleep(0.1)


def _answer(answer: dict[str, Any]) -> None:
    with contextlib.suppress(BrokenPipeError):  # the daemon was killed
        os.write(sys.stdout.fileno(), json.dumps(answer).encode() + b"\n")


if __name__ == "__main__":
    main()
