"""Prints all output on the terminal; no text from a file or a device is interpreted as markup or
control characters.

Titles, names, columns, file names and a device's answers come from other people. Control characters
in them could move the cursor, hide lines or type answers; they are printed as escapes. rich does
not interpret square brackets in them as markup.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import click
import rich.console
from rich.console import ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from arctrue.base.printable import harmless


class Console(rich.console.Console):
    """A console of rich for plain text and tables; it interprets no markup and escapes control
    characters."""

    def __init__(
        self, *, stderr: bool = False, highlight: bool = True, width: int | None = None
    ) -> None:
        """Create the console with the options of rich that the commands use."""
        super().__init__(stderr=stderr, highlight=highlight, width=width, markup=False, emoji=False)

    def render_str(self, text: str, **options: Any) -> Text:
        """Escape control characters before the layout, so that the widths of columns are
        correct."""
        return super().render_str(harmless(text), **options)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterator[Segment]:
        """Yield the segments of rich; control characters in their text are escaped."""
        for segment in super().render(renderable, options):
            if segment.control:
                yield segment
            else:
                yield Segment(harmless(segment.text), segment.style)


def say(text: str = "") -> None:
    """Print a line of the result, on stdout."""
    click.echo(harmless(text))


def note(text: str) -> None:
    """Print a line on stderr that is not part of the result."""
    click.echo(harmless(text), err=True)


def tell_error(text: str) -> None:
    """Print an error on stderr; the errors of all commands have this format."""
    note(f"error: {text}")


def tell_warning(text: str) -> None:
    """Print a warning on stderr; the command continues."""
    note(f"warning: {text}")


def tell_objection(text: str, *, forced: bool) -> None:
    """Print why a result is refused: as a warning if the user forces the result, otherwise as an
    error."""
    if forced:
        tell_warning(text)
    else:
        tell_error(f"refused: {text}")


def sentence(error: Exception) -> str:
    """Return an error as one sentence, with the file that cannot be read or written."""
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        return f"{error.filename}: cannot be read or written: {error.strerror}"
    return str(error)
