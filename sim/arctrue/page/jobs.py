"""Runs each ranking in its own process, which reports its progress and can be cancelled."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from arctrue.base.whole_file import write_whole_text
from arctrue.page.session import Session

AT_ONCE = 2
"""Largest number of rankings that run at the same time; further rankings wait."""
PROGRESS, CANCELLED, FAILED = "progress.json", "cancelled", "failed.txt"
_END_S = 5.0
_LOOK_S = 0.2


class Jobs:
    """Manages the processes that compute rankings, one process for each step of a session.

    A process starts when the page of the step is first opened.
    """

    def __init__(self, effect_folders: Sequence[Path]) -> None:
        """Store the folders from which the processes load effects."""
        self._folders = [str(folder) for folder in effect_folders]
        self._running: dict[tuple[str, int], _Job] = {}
        self._places = threading.BoundedSemaphore(AT_ONCE)
        self._lock = threading.Lock()

    def start(self, session: Session, number: int) -> None:
        """Start the ranking unless it is running or complete; a cancelled ranking starts again."""
        key = (session.name, number)
        with self._lock:
            if key in self._running or session.ranking_is_whole(number):
                return
            folder = session.step_folder(number)
            for name in (CANCELLED, FAILED, PROGRESS):
                (folder / name).unlink(missing_ok=True)
            command = [sys.executable, "-m", "arctrue.page.ranking_job", str(session.folder)]
            job = _Job([*command, str(number), *self._folders], folder)
            self._running[key] = job
        threading.Thread(target=self._run, args=(key, job), daemon=True).start()

    def _run(self, key: tuple[str, int], job: _Job) -> None:
        try:
            while not (placed := self._places.acquire(timeout=_LOOK_S)) and not job.is_ended:
                pass
            try:
                job.run()
            finally:
                if placed:
                    self._places.release()
        finally:
            with self._lock:
                self._running.pop(key, None)

    def cancel(self, session: Session, number: int) -> None:
        """End the ranking process of a step, if it is running; its partial result is kept."""
        with self._lock:
            job = self._running.get((session.name, number))
        if job is not None:
            job.end()

    def end_session(self, session: Session) -> None:
        """End all ranking processes of a session, and wait until none is running."""
        while True:
            with self._lock:
                jobs = [job for (name, _), job in self._running.items() if name == session.name]
            if not jobs:
                return
            for job in jobs:
                job.end()
            time.sleep(_LOOK_S / 4.0)

    def state(self, session: Session, number: int) -> dict[str, Any]:
        """Return the progress of the ranking of a step.

        ``state``: done, running, cancelled, failed or none; ``doing``: present activity, or the
        reason of a failure; ``seconds``: running time; ``partly``: whether a partial ranking
        exists.
        """
        folder = session.step_folder(number)
        with self._lock:
            job = self._running.get((session.name, number))
        if job is not None:
            return {
                "state": "running",
                **job.progress(),
                "partly": session.ranking(number) is not None,
            }
        if session.ranking_is_whole(number):
            return {"state": "done", "doing": "", "seconds": 0.0, "partly": True}
        partly = session.ranking(number) is not None
        if (folder / FAILED).is_file():
            text = (folder / FAILED).read_text(encoding="utf-8")
            return {"state": "failed", "doing": text, "seconds": 0.0, "partly": partly}
        state = "cancelled" if (folder / CANCELLED).is_file() else "none"
        return {"state": state, "doing": "", "seconds": 0.0, "partly": partly}

    def wait(self) -> None:
        """Wait until no ranking process is running."""
        while True:
            with self._lock:
                if not self._running:
                    return
            time.sleep(_LOOK_S / 4.0)

    def end_all(self) -> None:
        """End all ranking processes when the server stops."""
        with self._lock:
            jobs = list(self._running.values())
        for job in jobs:
            job.end()


class _Job:
    def __init__(self, command: list[str], folder: Path) -> None:
        self._command, self._folder = command, folder
        self._start = time.monotonic()
        self._ended = threading.Event()

    def progress(self) -> dict[str, Any]:
        seconds = round(time.monotonic() - self._start, 1)
        try:
            doing = json.loads((self._folder / PROGRESS).read_text(encoding="utf-8"))["doing"]
        except (OSError, ValueError, KeyError):
            doing = "starting, or waiting until another ranking ends"
        return {"doing": doing, "seconds": seconds}

    @property
    def is_ended(self) -> bool:
        return self._ended.is_set()

    def end(self) -> None:
        self._ended.set()

    def run(self) -> None:
        if self._ended.is_set():
            self._say(CANCELLED, "")
            return
        process = subprocess.Popen(
            self._command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )
        lines: list[bytes] = []
        assert process.stderr is not None
        reader = threading.Thread(target=lambda: lines.append(process.stderr.read()), daemon=True)  # type: ignore[union-attr]
        reader.start()
        while process.poll() is None and not self._ended.wait(_LOOK_S):
            pass
        if process.poll() is None:
            process.terminate()
            try:
                process.wait(_END_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            self._say(CANCELLED, "")
            return
        reader.join(_END_S)
        if process.returncode:
            text = b"".join(lines).decode(errors="replace").strip()
            self._say(FAILED, text.splitlines()[-1] if text else f"exit code {process.returncode}")

    def _say(self, name: str, text: str) -> None:
        try:
            write_whole_text(self._folder / name, text, make_folder=False)
        except OSError:
            return  # the session has been deleted
