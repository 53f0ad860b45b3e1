"""The one way to the terminal: what files hold is shown, never obeyed.

Titles, names, columns, file names and what a device says are other people's text. Control
characters in it could move the cursor, hide lines or type answers; they are shown as escapes.
Square brackets of it are no markup of rich.
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
    """A console of rich for plain text and tables: no markup, no control characters in text."""

    def __init__(
        self, *, stderr: bool = False, highlight: bool = True, width: int | None = None
    ) -> None:
        """As rich's, with the options that the commands use."""
        super().__init__(stderr=stderr, highlight=highlight, width=width, markup=False, emoji=False)

    def render_str(self, text: str, **options: Any) -> Text:
        """Harmless before the layout, so that columns are as wide as what is shown."""
        return super().render_str(harmless(text), **options)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterator[Segment]:
        """The segments of rich; what is text of them is harmless."""
        for segment in super().render(renderable, options):
            if segment.control:
                yield segment
            else:
                yield Segment(harmless(segment.text), segment.style)


def say(text: str = "") -> None:
    """Print a line of the result, on stdout."""
    click.echo(harmless(text))


def note(text: str) -> None:
    """Print a line beside the result, on stderr."""
    click.echo(harmless(text), err=True)


def tell_error(text: str) -> None:
    """Say on stderr what went wrong; every command's errors have this form."""
    note(f"error: {text}")


def tell_warning(text: str) -> None:
    """Say on stderr what should be looked at, although the command goes on."""
    note(f"warning: {text}")


def tell_objection(text: str, *, forced: bool) -> None:
    """Say why a result is refused; where the user forces it, that is a warning."""
    if forced:
        tell_warning(text)
    else:
        tell_error(f"refused: {text}")
