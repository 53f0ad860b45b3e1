"""How far a long command has come, on stderr: a live line in a terminal, else a line at times."""

from __future__ import annotations

import time
from pathlib import Path
from types import TracebackType
from typing import Self

from arctrue.base.printable import time_left
from arctrue.cli._terminal import Console

progress_console = Console(stderr=True)

SECONDS_BETWEEN_LINES = 10.0
MOST_SHARE = 0.99
"""What is told of a command that takes more steps than was thought."""
LONG_FILE_BYTES = 64 << 20
"""Shorter files are read before anybody could read a line about it."""


class Progress:
    """One step of a command; what it does may change, and how much of it is done."""

    _present: Progress | None = None

    def __init__(self, doing: str, *, steps: int = 0) -> None:
        """Starts with what is being done, in words; ``steps``: how many will follow, about."""
        self._doing = doing
        self._steps = steps
        self._done = 0
        self._begun = time.monotonic()
        self._status = progress_console.status(doing)
        self._last_line = time.monotonic()

    def __enter__(self) -> Self:
        """Shown until the block ends."""
        Progress._present = self
        self._status.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """The live line goes; nothing stays on the terminal."""
        Progress._present = None
        self._status.stop()

    def now(self, doing: str) -> None:
        """Another step begins; with ``steps``, how far that is and how long the rest may take."""
        self._doing = doing
        if self._steps:
            share = min(self._done / self._steps, MOST_SHARE)
            self._done += 1
            passed = time.monotonic() - self._begun
            left = time_left(passed * (1.0 - share) / share) if share else "?"
            self._doing = f"{doing} ({100.0 * share:.0f} %, {left} left)"
        self._show(self._doing)

    def keep(self, text: str) -> None:
        """A line that stays, above the live one."""
        progress_console.print(text, soft_wrap=True)

    def read(self, path: Path, done: int, total: int) -> None:
        """Bytes of a file that are read."""
        if total >= LONG_FILE_BYTES:
            self._show(f"reading {path.name}: {100.0 * done / total:.0f} % of {total / 1e6:.0f} MB")

    @staticmethod
    def rows(done: int, total: int) -> None:
        """Rows that a pass over a long capture has done, in whatever step is shown now."""
        step = Progress._present
        if step is not None:
            step._show(f"{step._doing}: {100.0 * done / total:.0f} % of {total:,} rows")

    def _show(self, text: str) -> None:
        self._status.update(text)
        if progress_console.is_terminal:
            return
        if time.monotonic() - self._last_line > SECONDS_BETWEEN_LINES:
            self._last_line = time.monotonic()
            self.keep(text)
