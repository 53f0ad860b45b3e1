"""Defines callbacks that receive the progress of a long computation and display it."""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar

ReportStep = Callable[[str], None]
"""Function that receives one line for people at the beginning of each step."""

SHOW_ROWS: ContextVar[Callable[[int, int], None] | None] = ContextVar("SHOW_ROWS", default=None)
"""Function that receives (done, total): processed rows and all rows of a pass over a long set."""


def rows_done(done: int, total: int) -> None:
    """Report how many rows a pass has processed."""
    show = SHOW_ROWS.get()
    if show is not None:
        show(done, total)
