"""Defines the functions that receive the progress of a long task and display it: ``report_step``
for steps, ``report_count`` for parts of a known number, ``report_bytes`` for a file."""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar
from pathlib import Path

ReportStep = Callable[[str], None]
"""Function that receives one line for people at the beginning of each step."""

ReportCount = Callable[[int, int], None]
"""Function that receives the number of finished parts and the number of all parts."""

ReportBytes = Callable[[Path, int, int], None]
"""Function that receives a file, the number of bytes read and the size of the file in bytes."""

SHOW_ROWS: ContextVar[ReportCount | None] = ContextVar("SHOW_ROWS", default=None)
"""Function that receives (done, total): processed rows and all rows of a pass over a long set."""


def rows_done(done: int, total: int) -> None:
    """Report how many rows a pass has processed."""
    show = SHOW_ROWS.get()
    if show is not None:
        show(done, total)
