"""How a long piece of work says what it is doing; who shows it is the caller's choice."""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar

ReportStep = Callable[[str], None]
"""Gets one line for people whenever another step begins."""

SHOW_ROWS: ContextVar[Callable[[int, int], None] | None] = ContextVar("SHOW_ROWS", default=None)
"""Who is shown how many rows of how many a pass over every row of a long set has done."""


def rows_done(done: int, total: int) -> None:
    """Say how far a pass over every row has come."""
    show = SHOW_ROWS.get()
    if show is not None:
        show(done, total)
