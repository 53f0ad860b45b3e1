"""Prints progress and error messages of the commands that run the virtual instrument."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from arctrue.cli._progress import Progress

if TYPE_CHECKING:
    from arctrue.instrument import RunProgress


class Shown:
    """Prints the messages of the instrument on stderr."""

    def __init__(self, step: Progress) -> None:
        """Store ``step``, which shows the live line while the command runs."""
        self._step = step

    def say(self, text: str) -> None:
        """Print a line that remains on the terminal."""
        self._step.keep(text)

    def progress(self, now: RunProgress) -> None:
        """Show the progress of the run."""
        self._step.now(now.words)


@contextmanager
def on_the_instrument(what: str = "") -> Iterator[Shown]:
    """Show the messages of the instrument; convert its errors to ValueError for :func:`for_people`.

    The message of such an error begins with ``what``.
    """
    from arctrue.instrument import InstrumentError

    with Progress("building the instrument") as step:
        try:
            yield Shown(step)
        except InstrumentError as error:
            raise ValueError(f"{what}: {error}" if what else str(error)) from error
