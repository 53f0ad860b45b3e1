"""Reports why a file is not written."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from arctrue.cli._terminal import tell_error, tell_objection, tell_warning

NOT_WRITTEN = 1
"""Exit code of a command that did not write its file."""


def may_write(warnings: Iterable[str], refused: Sequence[str], *, force: bool) -> bool:
    """Print warnings and objections; return True if there is no objection or the user forces the
    file."""
    for warning in warnings:
        tell_warning(warning)
    for objection in refused:
        tell_objection(objection, forced=force)
    return force or not refused


def end_unless_written(path: Path, *, written: bool) -> None:
    """End the command with NOT_WRITTEN if the file was not written."""
    if not written:
        tell_error(f"{path} was not written; --force writes it")
        raise SystemExit(NOT_WRITTEN)
