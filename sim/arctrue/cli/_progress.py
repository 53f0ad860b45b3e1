"""Shows the progress of a long command on stderr, as a live line on a terminal or as a line every
10 s in a file."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Self

from arctrue.base.printable import time_left
from arctrue.cli._terminal import Console

progress_console = Console(stderr=True)

SECONDS_BETWEEN_LINES = 10.0
MOST_SHARE = 0.99
"""Fraction of the work that is shown as done when a command takes more steps than expected."""
LONG_FILE_BYTES = 64 << 20
"""Smallest length of a file, in bytes, for which a progress line is shown; a shorter file is read
before a user could read the line."""


class Progress:
    """Progress of one command; a live text names the present task."""

    _present: Progress | None = None

    def __init__(self, doing: str, *, steps: int = 0) -> None:
        """Store ``doing``, the name of the first task, and ``steps``, the expected number of later
        tasks."""
        self._doing = doing
        self._steps = steps
        self._done = 0
        self._begun = time.monotonic()
        self._status = progress_console.status(doing)
        self._last_line = time.monotonic()

    def __enter__(self) -> Self:
        """Show the live line until the ``with`` block ends."""
        Progress._present = self
        self._status.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Remove the live line from the terminal."""
        Progress._present = None
        self._status.stop()

    def now(self, doing: str) -> None:
        """Begin the next task; if ``steps`` was given, show the fraction done and the estimated
        remaining time."""
        self._doing = doing
        if self._steps:
            share = min(self._done / self._steps, MOST_SHARE)
            self._done += 1
            passed = time.monotonic() - self._begun
            left = time_left(passed * (1.0 - share) / share) if share else "?"
            self._doing = f"{doing} ({100.0 * share:.0f} %, {left} left)"
        self._show(self._doing)

    def keep(self, text: str) -> None:
        """Print a line above the live line; the printed line remains."""
        progress_console.print(text, soft_wrap=True)

    def read(self, path: Path, done: int, total: int) -> None:
        """Show how many bytes of a long file have been read so far."""
        if total >= LONG_FILE_BYTES:
            self._show(f"reading {path.name}: {100.0 * done / total:.0f} % of {total / 1e6:.0f} MB")

    @staticmethod
    def rows(done: int, total: int) -> None:
        """Show within the present task how many rows of a long capture have been processed."""
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
