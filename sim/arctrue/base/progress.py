"""Callbacks by which a long computation reports its progress; the caller decides on display."""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar

ReportStep = Callable[[str], None]
"""Receives one line for people at the beginning of each step."""

SHOW_ROWS: ContextVar[Callable[[int, int], None] | None] = ContextVar("SHOW_ROWS", default=None)
"""Receives (done, total): the rows that a pass over a long set has processed."""


def rows_done(done: int, total: int) -> None:
    """Report how many rows a pass has processed."""
    show = SHOW_ROWS.get()
    if show is not None:
        show(done, total)
