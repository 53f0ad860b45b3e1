"""Prints all output on the terminal; no text from a file or a device is interpreted as markup or
control characters.

Titles, names, columns, file names and a device's answers come from other people. Control characters
in these texts could move the cursor, hide lines or send input to the shell, so they are printed as
escapes. rich does not interpret square brackets in these texts as markup.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from typing import Any, NoReturn

import click
import rich.console
from rich.console import ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from arctrue.base.printable import harmless

EXIT_NO_READER = 141
"""Exit code that a shell reports for a program whose reader closed the pipe: 128 + SIGPIPE."""


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

    def on_broken_pipe(self) -> NoReturn:
        """End the program as :func:`say` does."""
        _end_without_reader()

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterator[Segment]:
        """Yield the segments of rich; control characters in their text are escaped."""
        for segment in super().render(renderable, options):
            if segment.control:
                yield segment
            else:
                yield Segment(harmless(segment.text), segment.style)


def _end_without_reader() -> NoReturn:
    """End the program quietly after the reader of a pipe, such as ``head``, has closed it."""
    # Python flushes stdout once more at the end of the program.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    raise SystemExit(EXIT_NO_READER)


def say(text: str = "", *, error: bool = False) -> None:
    """Print a line of the result, on stdout. End the program if nobody reads the output."""
    try:
        click.echo(harmless(text), err=error)
    except BrokenPipeError:
        _end_without_reader()


def note(text: str) -> None:
    """Print a line on stderr that is not part of the result."""
    say(text, error=True)


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
